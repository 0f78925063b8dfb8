"""`ertel app`."""

from pathlib import Path
from typing import Annotated

import typer

from ertel.apps.terminal import BAD_INPUT, bad_input, in_shell, leave, local_path, say

PORT = 8642
MISSING = "the app needs NiceGUI: pip install 'ertel[app]'"


def browse(
    folder: Annotated[
        Path,
        typer.Argument(
            parser=local_path,
            metavar="[DIR]",
            help="Folder with case files and runs; default here.",
            show_default=False,
        ),
    ] = Path(),
    port: Annotated[int, typer.Option(min=1024, max=65535, help="Port on this machine.")] = PORT,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the app in the browser.")] = True,
) -> None:
    """Describe, run and watch cases in a browser on this machine.

    The app reads and writes in DIR only. It answers only the browser that opens its address, which carries a token:
    whoever has the address can use the app. Each run is a process of its own that goes on
    when the app is closed; its Close button can stop the runs, too. Ctrl-C closes the app.
    """
    try:
        from ertel.apps.browser import launch
    except ModuleNotFoundError as error:
        if error.name != "nicegui":
            raise
        leave(BAD_INPUT, MISSING)
    if not launch.is_free(port):
        leave(BAD_INPUT, f"--port {port}: is taken, perhaps by this app in another terminal; choose another port")
    with bad_input():
        going = launch.serve(
            folder.absolute(), port, browser, lambda address: say(f"The app is at {address}, Ctrl-C closes it")
        )
    for name in going:
        run = in_shell(folder.absolute() / name)
        say(f"{run} goes on without the app; to watch it open the app again")
