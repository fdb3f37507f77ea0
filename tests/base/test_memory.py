"""Memory that a computation no longer needs goes back to the system, and memory in use stays."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

import pytest

from cramlite.base.memory import _trim, give_back

BLOCK, COUNT, EVERY = 100_000, 1000, 10
STATE = Path("/proc/self/statm")


def resident() -> int:
    return int(STATE.read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not STATE.exists() or _trim() is None, reason="the C library keeps no free memory, or cannot say so")
def test_free_memory_between_blocks_in_use_goes_back() -> None:
    """100 MB, of which every tenth block is in use and keeps the heap from being made smaller."""
    library = ctypes.CDLL(None)
    library.malloc.restype, library.free.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    library.memset.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_size_t]
    give_back()  # what tests before this one have left
    blocks = [library.malloc(BLOCK) for _ in range(COUNT)]
    for block in blocks:
        library.memset(block, 1, BLOCK)
    used = resident()
    give_back()
    assert resident() > used - COUNT * BLOCK // 20, "what is in use stays"
    for k, block in enumerate(blocks):
        if k % EVERY:
            library.free(block)
    give_back()
    assert resident() < used - COUNT * BLOCK * 7 // 10
    assert all(ctypes.string_at(block, 1) == b"\x01" for block in blocks[::EVERY])
    for block in blocks[::EVERY]:
        library.free(block)
