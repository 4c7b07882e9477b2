"""The command that opens the explorer: ``celltrain explore``."""

from pathlib import Path
from typing import Annotated, NoReturn

from cyclopts import Parameter

from celltrain.cli.arguments import Quiet
from celltrain.cli.keeping import Keeper
from celltrain.cli.options import reader
from celltrain.cli.progress import Reporter
from celltrain.extras import check_installed
from celltrain.parameters import CaseError

Opened = Annotated[
    Path | None,
    Parameter(
        help="TOML file of a case, netCDF file of a result or a simulation (.nc), or folder of a"
        " study; a usual train unless given."
    ),
]
Host = Annotated[
    str,
    Parameter(
        help="Address to listen on; any but this machine's own is guarded by a token, which the"
        " page's address carries."
    ),
]
Port = Annotated[
    int | None,
    Parameter(
        converter=reader(int, "allowed: a whole number from 0 (any that is free) to 65535"),
        help="Port to listen on; 8157 unless given, or any that is free.",
    ),
]
Token = Annotated[
    str | None, Parameter(help="Token that the page's address must carry; made up if needed.")
]
Browser = Annotated[bool, Parameter(help="Open the page in the browser.")]


def explore(
    file: Opened = None,
    /,
    *,
    browser: Browser = True,
    host: Host = "127.0.0.1",
    port: Port = None,
    token: Token = None,
    quiet: Quiet = False,
) -> NoReturn:
    """Open a train in the browser: sliders, the cells in three dimensions, spectrum and modes."""
    check_installed("explore")
    if port is not None and not 0 <= port <= 65535:
        raise CaseError(f"port = {port} is not allowed; allowed: a whole number from 0 to 65535")
    if token == "":
        raise CaseError("token = '' is not allowed; allowed: a word that is not empty")
    from celltrain.explore.opened import opened

    what = opened(file)
    with Reporter(quiet=quiet) as reporter:
        reporter.log("warming up: the first train, so that the page answers at once")
        from celltrain.explore.app import make_app
        from celltrain.explore.engine import Engine
        from celltrain.explore.server import serve

        engine = Engine(what.start)
        engine.warm_up(what.view)
        query = what.view.address
        served = serve(make_app(what, engine), host=host, port=port, token=token, query=query)
        reporter.log("Ctrl-C ends it")
    Keeper(quiet=quiet).show(lambda: print(served.address))
    # It ends by being interrupted, which the server keeps to itself.
    served.run(browser=browser)
    raise KeyboardInterrupt("the page has ended")
