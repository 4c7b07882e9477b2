"""The figure of a simulation: how its disturbance grows, beside the linear theory."""

import numpy as np

from celltrain.evolution import Run
from celltrain.explore.figures import INK, Figure, axis, figure, logarithmic
from celltrain.explore.reading import Reading
from celltrain.pictures.run import run_growth, spread
from celltrain.pictures.style import BLUE, VERMILION

# More points than a curve's width shows.
MOST_POINTS = 600


def simulation_figure(run: Run, reading: Reading) -> Figure:
    """eps(t) and eps_x(t) of a simulation, |exp(A t) v| and exp(alpha t), as Figs. 4 and 11."""
    growth = run_growth(run)
    chosen = spread(len(growth.times), MOST_POINTS)
    time, unit = reading.of("r0/U")
    length, length_unit = reading.of("r0")
    times = growth.times[chosen]
    # The film goes on to the end of the last step, whose beginning is the last of these times.
    ends = [float(run.times[0]) * time, float(max(run.times[-1], growth.times[-1])) * time]
    curves = [("simulation, ε", growth.size, BLUE, "solid", 2.2)]
    if growth.displacement is not None:
        curves.append(("simulation, ε<sub>x</sub>", growth.displacement, VERMILION, "solid", 2.2))
    if growth.linear is not None:
        curves.append(("linear, |e<sup>At</sup> v|", growth.linear, INK, "dash", 1.3))
    if growth.growth_rate is not None:
        exponential = growth.size[0] * np.exp(growth.growth_rate * growth.times)
        curves.append(("e<sup>αt</sup>", exponential, INK, "dot", 1.3))
    seen = np.concatenate([each[1] for each in curves[:2]])
    top = 3.0 * max(float(np.nanmax(seen)), 1e-12) * length
    bottom = 0.5 * max(float(np.nanmin(seen, where=seen > 0.0, initial=np.inf)), 1e-12) * length
    return figure(
        [
            {
                "type": "scatter",
                "mode": "lines",
                "x": (times * time).tolist(),
                "y": [float(f"{each:.6g}") for each in values[chosen] * length],
                "name": name,
                "line": {"color": color, "width": width, "dash": dash},
                "hovertemplate": f"{name}: %{{y:.4g}} {length_unit}<extra></extra>",
            }
            for name, values, color, dash, width in curves
        ],
        xaxis=axis(f"time t ({unit})", range=ends),
        yaxis=axis(
            f"size of the disturbance ({length_unit})",
            **logarithmic(bottom, top),
        ),
        showlegend=True,
        legend={"x": 0.02, "y": 0.98, "bgcolor": "rgba(255,255,255,0.7)", "font": {"size": 11}},
        uirevision=unit,
        # The vertical line shows the time of the film, which is in r0/U.
        meta={"time": time},
        shapes=[
            {
                "type": "line",
                "xref": "x",
                "yref": "paper",
                "x0": 0,
                "x1": 0,
                "y0": 0,
                "y1": 1,
                "line": {"color": "#5b6875", "width": 1},
            }
        ],
    )
