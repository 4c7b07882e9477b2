"""The commands of all analyses, made from them: `celltrain NAME` for each in the catalogue."""

from collections.abc import Callable, Sequence
from dataclasses import MISSING, fields, make_dataclass
from dataclasses import field as dataclass_field
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Literal,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

from cyclopts import Group, Parameter

from celltrain.cli.arguments import CaseFile, Json, Output, OwnOutput, Plot, Quiet, Start
from celltrain.cli.compute import Request, run
from celltrain.cli.options import OPTIONS, CaseOptions, given_leaves, reader
from celltrain.contract import Analysis, InFolder, Setting, WrittenMeanwhile, analysis_named
from celltrain.quantities import Record

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Command = Callable[..., int]
#: Options of every command, which no setting may take.
_RESERVED = {
    *(each.name for each in fields(OPTIONS)),
    *("case", "start", "output", "plot", "json", "quiet", "workers", "scheduler", "retry"),
}


def __getattr__(name: str) -> Command:
    if name.startswith("_"):
        raise AttributeError(name)
    try:
        analysis = analysis_named(name)
    except KeyError as error:
        raise AttributeError(str(error)) from None
    return command_of_many(analysis) if issubclass(analysis, InFolder) else command(analysis)


def command(analysis: type[Analysis[Record]]) -> Command:
    """The command of an analysis: its settings, and the options of every case, are its options."""
    options = settings_class(analysis)

    def compute(
        case: CaseFile = None,
        /,
        *,
        settings: Any,
        options: CaseOptions = None,
        start: Start = None,
        output: Output = None,
        plot: Plot = None,
        json: Json = False,
        quiet: Quiet = False,
    ) -> int:
        given = {} if settings is None else vars(settings)
        request = Request(case, start, output, plot, json, quiet)
        return run(request, given_leaves(options), analysis(**given))

    _take_settings(compute, options)
    if issubclass(analysis, WrittenMeanwhile):
        compute.__annotations__["output"] = OwnOutput
    compute.__doc__ = analysis.__doc__
    compute.__name__ = analysis.command or analysis.result.kind
    return compute


def command_of_many(computation: type[InFolder]) -> Command:
    """The command of a computation of many cases: its argument, and its settings as options."""
    from celltrain.cli.in_folder import (
        Count,
        FolderRequest,
        Retry,
        Scheduler,
        folder_option,
        run_in_folder,
    )

    options = settings_class(computation)

    def compute(
        argument: Any,
        /,
        *,
        settings: Any,
        output: Path | None = None,
        workers: Count = None,
        scheduler: Scheduler = None,
        retry: Retry = False,
        json: Json = False,
        quiet: Quiet = False,
    ) -> int:
        given = {} if settings is None else vars(settings)
        request = FolderRequest(output, workers, scheduler, retry, json, quiet)
        return run_in_folder(request, computation(**{computation.argument: argument}, **given))

    hint = get_type_hints(computation, include_extras=True)[computation.argument]
    kind, setting = get_args(hint)
    name = computation.argument.upper()
    compute.__annotations__ |= {
        "argument": Annotated[kind, Parameter(name=name, help=setting.help)],
        "output": folder_option(computation),
    }
    _take_settings(compute, options)
    compute.__doc__ = computation.__doc__
    compute.__name__ = computation.__name__.lower()
    return compute


def _take_settings(compute: Command, options: "type[DataclassInstance]") -> None:
    """Let the parameter `settings` of a command take these options, if there are any."""
    needed = any(each.default is MISSING for each in fields(options))
    kind = options if needed else options | None
    parameter = Parameter(name="*") if fields(options) else Parameter(parse=False)
    compute.__annotations__["settings"] = Annotated[kind, parameter]  # type: ignore[valid-type]
    if not needed:
        compute.__kwdefaults__ = (compute.__kwdefaults__ or {}) | {"settings": None}


def settings_class(analysis: type[Analysis[Record] | InFolder]) -> "type[DataclassInstance]":
    """A dataclass of an analysis' settings for cyclopts to read options into."""
    hints = get_type_hints(analysis, include_extras=True)
    group = Group("Analysis", sort_key=1)
    columns: list[tuple[str, Any, Any]] = []
    for each in fields(cast(Any, analysis)):
        if each.name == getattr(analysis, "argument", None):
            continue
        kind, *notes = get_args(hints[each.name]) or (None,)
        setting = next((note for note in notes if isinstance(note, Setting)), None)
        if setting is None:
            raise TypeError(f"{analysis.__name__}: the field {each.name!r} has no Setting")
        if each.name in _RESERVED:
            raise TypeError(f"{analysis.__name__}: the setting {each.name!r} is an option already")
        default = {} if each.default is MISSING else {"default": each.default}
        parameter = _parameter(kind, setting, group, each.default)
        columns.append((each.name, Annotated[kind, parameter], dataclass_field(**default)))
    made = make_dataclass(f"{analysis.__name__}Options", columns, frozen=True, kw_only=True)
    made.__module__ = __name__  # cyclopts only looks into classes of modules like this one
    return made


def _parameter(kind: Any, setting: Setting, group: Group, default: Any) -> Parameter:
    inner = _inner(kind)
    converter = None
    if inner in (int, float):
        converter = reader(inner, f"allowed: {setting.allowed or 'numbers'}")
    return Parameter(
        name=f"--{setting.option}" if setting.option else None,
        help=f"{setting.help} (allowed: {setting.allowed})" if setting.allowed else setting.help,
        group=group,
        converter=converter,
        # What is on by default must have a way to be switched off.
        negative=None if default is True else (),
        consume_multiple=_is_sequence(kind),
    )


def _is_sequence(kind: Any) -> bool:
    return any(get_origin(each) is Sequence for each in (kind, *get_args(kind)))


def _inner(kind: Any) -> Any:
    """The type of a setting's values, which may be optional, or several."""
    parts = [each for each in get_args(kind) if each is not type(None)]
    return _inner(parts[0]) if parts and get_origin(kind) is not Literal else kind
