"""Frames of a simulation as files for ParaView: surfaces with velocity and tension.

Each frame is a file of the format "VTK XML PolyData" (.vtp), which every version of ParaView reads;
a collection (.pvd) names them with their times. Numbers are 32 bits long and stand, as they are in
memory, behind the description ("appended raw").
"""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Int

from celltrain.diagnostics import surface_fields
from celltrain.harmonics import mean_points, real_harmonics
from celltrain.membrane.energy import Membrane
from celltrain.parameters import CaseError, Train
from celltrain.results import replace_file
from celltrain.train import train_membrane

VTK_TYPES = {"f4": "Float32", "i4": "Int32"}
# Faces around the tube.
TUBE_FACES = 96


@dataclass(frozen=True)
class PolyData:
    """A surface of polygons, with values at its points.

    Attributes:
        points: positions.
        polygons: point numbers of all polygons, one after another.
        offsets: where each polygon ends in `polygons`.
        point_data: arrays by name, one row for each point.
    """

    points: Float[np.ndarray, "point 3"]
    polygons: Int[np.ndarray, " corner"]
    offsets: Int[np.ndarray, " polygon"]
    point_data: dict[str, np.ndarray]


def export_paraview(
    train: Train,
    times: Float[np.ndarray, " time"],
    shapes: Float[np.ndarray, "frame cell 3 coefficient"],
    rates: Float[np.ndarray, "..."],
    directory: str | Path,
) -> Path:
    """Write frames of a simulation for ParaView into a folder, made if need be.

    **Arguments:** `times` in r0/U, `shapes` in r0, and `rates` = ds/dt in U, in whose frame the
    velocities are.

    **Returns:** `frames.pvd`, the file to open. It names the files `cells_00000.vtp` and so on; in
    these every point has `velocity` (U), `relative_velocity` (U; less the mean over the points of
    its cell, over solid angle), `tension` (mu U; isotropic) and `cell` (number). `tube.vtp` is the
    wall.

    **Raises:** `CaseError` if the arrays do not fit together, `OSError` if a file cannot be
    written.
    """
    degree = train.degree
    if (
        shapes.ndim != 4
        or shapes.shape[2:] != (3, degree**2)
        or rates.shape != shapes.shape
        or len(times) != len(shapes)
        or len(times) == 0
    ):
        raise CaseError(
            f"times {np.shape(times)}, shapes {shapes.shape} and rates {rates.shape} are not"
            f" allowed: a train of degree {degree} has [time], and twice"
            f" [time, cell, 3, {degree**2}], with at least one time"
        )
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    membrane = train_membrane(train)
    collection = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    entries = ElementTree.SubElement(collection, "Collection")
    for number, time in enumerate(times):
        name = f"cells_{number:05d}.vtp"
        write_poly_data(_cells(membrane, train, shapes[number], rates[number]), folder / name)
        ElementTree.SubElement(
            entries, "DataSet", timestep=repr(float(time)), group="", part="0", file=name
        )
    height = mean_points(shapes)[:, :, 2]
    ends = height.min() - 0.5 * train.period, height.max() + 0.5 * train.period
    write_poly_data(_tube(train.radius, *ends), folder / "tube.vtp")
    path = folder / "frames.pvd"
    ElementTree.indent(collection)
    words = ElementTree.tostring(collection, encoding="utf-8", xml_declaration=True)
    replace_file(path, lambda part: part.write_bytes(words))
    return path


def write_poly_data(data: PolyData, path: Path) -> None:
    """Write one surface as a .vtp file.

    **Raises:** `OSError` if the file cannot be written.
    """
    root = ElementTree.Element(
        "VTKFile",
        type="PolyData",
        version="1.0",
        byte_order="LittleEndian",
        header_type="UInt64",
    )
    piece = ElementTree.SubElement(
        ElementTree.SubElement(root, "PolyData"),
        "Piece",
        NumberOfPoints=str(len(data.points)),
        NumberOfVerts="0",
        NumberOfLines="0",
        NumberOfStrips="0",
        NumberOfPolys=str(len(data.offsets)),
    )
    content = bytearray()
    values = ElementTree.SubElement(piece, "PointData")
    for name, array in data.point_data.items():
        kind = "i4" if np.issubdtype(array.dtype, np.integer) else "f4"
        _append(content, values, name, array, kind)
    _append(content, ElementTree.SubElement(piece, "Points"), "Points", data.points, "f4")
    polygons = ElementTree.SubElement(piece, "Polys")
    _append(content, polygons, "connectivity", data.polygons, "i4")
    _append(content, polygons, "offsets", data.offsets, "i4")
    ElementTree.SubElement(root, "AppendedData", encoding="raw").text = "_"
    ElementTree.indent(root)
    # The bytes, which no XML writer would leave alone, go where the underscore is.
    before, after = ElementTree.tostring(root).rsplit(b"_</", 1)
    words = b'<?xml version="1.0"?>\n' + before + b"_" + content + b"</" + after
    replace_file(path, lambda part: part.write_bytes(words))


def _append(
    content: bytearray, parent: ElementTree.Element, name: str, array: np.ndarray, kind: str
) -> None:
    """Describe an array, and append the number of its bytes and the bytes."""
    values = np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()
    ElementTree.SubElement(
        parent,
        "DataArray",
        type=VTK_TYPES[kind],
        Name=name,
        NumberOfComponents=str(array.shape[1] if array.ndim == 2 else 1),
        format="appended",
        offset=str(len(content)),
    )
    content += np.array(len(values), dtype="<u8").tobytes() + values


def _cells(
    membrane: Membrane,
    train: Train,
    shapes: Float[np.ndarray, "cell 3 coefficient"],
    rates: Float[np.ndarray, "cell 3 coefficient"],
) -> PolyData:
    """All cells of one frame: the rings of the membrane's grid, closed by a point at each pole."""
    fields = surface_fields(membrane, jnp.asarray(shapes), jnp.asarray(rates))
    rings = train.sizes.energy_order
    poles = real_harmonics(train.degree, np.array([0.0, np.pi]), np.zeros(2))
    end_weights = _pole_weights(rings)
    tension = np.asarray(fields.tension).reshape(len(shapes), rings, -1)
    ends = tension.mean(axis=2) @ end_weights.T
    polygons, offsets = closed_rings(rings, 2 * rings)
    count = rings * 2 * rings + 2
    cells = np.arange(len(shapes))
    velocity = _with_poles(fields.velocity, rates, poles)
    mean = mean_points(rates)[:, None]
    return PolyData(
        points=_with_poles(fields.position, shapes, poles).reshape(-1, 3),
        polygons=(polygons + count * cells[:, None]).ravel(),
        offsets=(offsets + len(polygons) * cells[:, None]).ravel(),
        point_data={
            "velocity": velocity.reshape(-1, 3),
            "relative_velocity": (velocity - mean).reshape(-1, 3),
            "tension": np.concatenate(
                [ends[:, :1], tension.reshape(len(shapes), -1), ends[:, 1:]], axis=1
            ).ravel(),
            "cell": np.repeat(cells, count),
        },
    )


def _with_poles(
    values: object,
    coefficients: Float[np.ndarray, "cell 3 coefficient"],
    poles: Float[np.ndarray, "2 coefficient"],
) -> Float[np.ndarray, "cell vertex 3"]:
    """Values of a field on the grid between its values at the two poles."""
    ends = np.swapaxes(coefficients @ poles.T, 1, 2)
    return np.concatenate([ends[:, :1], np.asarray(values), ends[:, 1:]], axis=1)


def _pole_weights(rings: int) -> Float[np.ndarray, "2 ring"]:
    """Weights of the means over rings in the values at the poles of a smooth field.

    A mean over longitude is a smooth function of cos(theta): its polynomial through the
    Gauss-Legendre nodes, sum_n (n + 1/2) P_n(+-1) sum_i w_i P_n(x_i) f_i.
    """
    nodes, weights = np.polynomial.legendre.leggauss(rings)
    degrees = np.arange(rings)
    # Rings go from theta = 0, cos(theta) = 1.
    table = np.polynomial.legendre.legvander(nodes[::-1], rings - 1) * weights[::-1, None]
    return np.stack([table @ ((degrees + 0.5) * sign**degrees) for sign in (1.0, -1.0)])


def closed_rings(
    rings: int, azimuths: int
) -> tuple[Int[np.ndarray, " corner"], Int[np.ndarray, " polygon"]]:
    """Polygons, and where each ends, of a closed surface: north pole, rings southwards, south pole.

    Triangles at the poles, quadrilaterals elsewhere, counter-clockwise seen from outside.
    """
    ring = 1 + azimuths * np.arange(rings)[:, None] + np.arange(azimuths)
    after = np.roll(ring, -1, axis=1)
    south = 1 + rings * azimuths
    north_faces = np.stack([np.zeros(azimuths, dtype=int), ring[0], after[0]], axis=-1)
    quads = np.stack([ring[:-1], ring[1:], after[1:], after[:-1]], axis=-1)
    south_faces = np.stack([ring[-1], np.full(azimuths, south), after[-1]], axis=-1)
    polygons = np.concatenate([north_faces.ravel(), quads.ravel(), south_faces.ravel()])
    sizes = np.repeat([3, 4, 3], [azimuths, (rings - 1) * azimuths, azimuths])
    return polygons, np.cumsum(sizes)


def _tube(radius: float, start: float, end: float) -> PolyData:
    angle = 2 * np.pi * np.arange(TUBE_FACES) / TUBE_FACES
    circle = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=-1)
    points = np.concatenate([circle + np.array([0.0, 0.0, z]) for z in (start, end)])
    here = np.arange(TUBE_FACES)
    after = np.roll(here, -1)
    quads = np.stack([here, after, after + TUBE_FACES, here + TUBE_FACES], axis=-1)
    return PolyData(points, quads.ravel(), 4 * np.arange(1, TUBE_FACES + 1), {})
