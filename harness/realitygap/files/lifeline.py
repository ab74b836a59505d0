"""A process that ends when the one that started it is gone, however that one ended."""

import os
import threading
import time

LOOK = 0.5
"""s between looks."""


def end_with(parent: int) -> None:
    """End this process, whatever it is at, soon after its parent of that number has ended."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
