"""The application that openenv.yaml names. Settings are environment variables:

ENFILADE_DATA      folder of the data set; without it, a small synthetic one is made at the start
ENFILADE_EPISODES  task and split (default: r2r/val_unseen)
ENFILADE_PROMPT    text, marks, navgpt, mapgpt, or a file (default: text)
"""

from __future__ import annotations

import os
import tempfile

import enfilade
import uvicorn
from enfilade import openenv


def data_folder() -> str:
    """The folder of the data set."""
    folder = os.environ.get("ENFILADE_DATA")
    if folder:
        return folder
    folder = tempfile.mkdtemp(prefix="enfilade-")
    enfilade.write_small_dataset(folder)
    return folder


app = openenv.app(
    os.environ.get("ENFILADE_EPISODES", "r2r/val_unseen"),
    data=data_folder(),
    subset="all",
    prompt=os.environ.get("ENFILADE_PROMPT", "text"),
)


def main(host: str = "0.0.0.0", port: int = 8000) -> None:
    """Serves the application."""
    uvicorn.run(app, host=host, port=port)


if __name__ == "__main__":
    main()
