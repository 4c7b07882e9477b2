"""All pictures of a result."""

from pathlib import Path

from celltrain.pictures.profile import draw_profile
from celltrain.pictures.spectrum import draw_spectrum
from celltrain.pictures.train import draw_base_train, draw_leading_mode, draw_transient_mode
from celltrain.stability import Stability
from celltrain.steady import Base


def plot_all(result: Base | Stability, directory: str | Path) -> list[Path]:
    """Draw every picture of a result into a folder, made if need be; returns the files.

    Of a steady train, the train and its cross-section; of its stability also the spectrum, the
    train with its leading mode, and with the disturbance that grows most at first.

    Raises:
        OSError: if the folder or a picture cannot be written.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    base = result.base if isinstance(result, Stability) else result
    paths = [
        draw_base_train(base, folder / "base_train.png"),
        draw_profile(base, folder / "profile.png"),
    ]
    if isinstance(result, Stability):
        paths += [
            draw_spectrum(result, folder / "spectrum.png"),
            draw_leading_mode(result, folder / "leading_mode.png"),
            draw_transient_mode(result, folder / "transient_mode.png"),
        ]
    return paths
