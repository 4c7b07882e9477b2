"""How the results of studies of distributions are shown; `celltrain sweep` computes them."""

from collections.abc import Mapping
from typing import NoReturn

from rich.console import Console

from celltrain.contract import Draw, Presentation
from celltrain.contract.status import ExitStatus
from celltrain.parameters import CaseError
from celltrain.results import Plain, plain
from celltrain.study.sampling.result import SampleResult
from celltrain.version import __version__


class SamplePresentation(Presentation[SampleResult]):
    """Quantiles, indices and histograms of a sample."""

    result = SampleResult

    @classmethod
    def steady_train(cls, result: SampleResult) -> NoReturn:
        """There is none: a sample keeps numbers only.

        Raises:
            CaseError: always.
        """
        raise CaseError(
            "a sample's dataset is not allowed here: it holds numbers only, and no steady train;"
            " allowed: the file of the train of the means, in the same folder"
        )

    @classmethod
    def report(cls, result: SampleResult, console: Console) -> None:
        """Print the tables."""
        console.print(result.table(), end="", markup=False, highlight=False, soft_wrap=True)

    @classmethod
    def summary(cls, result: SampleResult) -> dict[str, Plain]:
        """What is estimated from the trains, and those that failed; files keep every train."""
        data = result.data
        estimates = data.drop_vars([name for name, each in data.items() if "point" in each.dims])
        content = plain(estimates.to_dict(encoding=False))
        assert isinstance(content, dict)
        counts = {
            status: int((data["status"] == status).sum())
            for status in ("finished", "failed", "not computed")
        }
        return {
            "version": __version__,
            "kind": result.kind,
            **content,
            "trains": counts,
            "failures": plain(result.failures()),
        }

    @classmethod
    def pictures(cls, result: SampleResult) -> Mapping[str, Draw]:
        """Histograms of the outputs, and bars of the indices."""
        from celltrain.pictures.sample import sample_pictures

        return sample_pictures(result.data)

    @classmethod
    def status(cls, result: SampleResult) -> int:
        """3 if trains failed."""
        return ExitStatus.NOT_CONVERGED if result.failed else ExitStatus.DONE
