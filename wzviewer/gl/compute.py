"""The order of a frame made on the GPU, where OpenGL is 4.3 or more: the twin of `gl.order`.

::

    runs ──slice_table──► slices          2048 records of one run each, 32 bytes a slice
                            │
    records ──────► key.comp              relative depth -> sortable bits; invisible surfels go; the
                            │             survivors of a slice stay in scene order
                            ▼
              ┌─► histogram.comp          keys by digit, counts[digit][tile]     ┐
              │   scan.comp               exclusive sums along the rows          │ 4 passes, of
              └── scatter.comp            stable rank in the tile, out in order  ┘ 8 bits each
                            │
                            ▼
                 index, indirect          record numbers farthest first; DrawElementsIndirect

The result is that of `order_runs`, bit for bit: the key is the same float32 operations in the same
order, none of them fused, and a stable sort of keys that start in scene order settles ties by place.
The number of survivors stays on the GPU: it goes from the first scatter to the draw.

Radix and not bitonic: the four passes take what n takes, whatever n is.  A bitonic network pads to
the next power of two (one surfel more can double the work), runs log2(n) (log2(n) + 1) / 2 rounds
(210 at a million), and is not stable, so its keys would have to carry the place as well.

Memory traffic per surfel, bytes: 32 to read the record and 8 to write key and number; 4 + 8 + 8 in
each pass (4 less in the last, whose keys nobody wants); counts are 4 x 256 / 2048 four times a pass,
8 in all.  Together 124, of which 84 fall on survivors only: 0.1 GB for 783 k surfels.
Memory held is 16 bytes per surfel and a little.

No subgroup operations (they are optional everywhere), and no workgroup waits for another one: GL
does not promise that a waiting workgroup lets its elder go on, so prefix sums take a dispatch each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.reference import DEPTH_QUANTUM, Focus
from wzviewer.errors import ContextError
from wzviewer.gl.order import Run, UIntArray
from wzviewer.gl.records import INT16_STEPS, RECORD_BYTES
from wzviewer.gl.shader import Define, load_compute

COMPUTE_VERSION = 430
DIGIT_BITS = 8
RADIX = 1 << DIGIT_BITS
PASSES = 32 // DIGIT_BITS
THREADS = RADIX  # one invocation per digit
TILE = 2048  # keys per workgroup: as many words as the masks of two stripes have
MAX_TILES = 65535  # workgroups that every driver dispatches
STATE_WORDS = 8 + RADIX  # the draw command, padded, and the totals
BLOCK_FLOOR_BYTES = 1 << 24  # what OpenGL 4.3 promises
WINDOW_STEP = 8  # records: offsets of bound ranges are multiples of 256 bytes
GROWTH = 1.25  # capacity beyond the need, so that a moving camera does not reallocate

SLICE_DTYPE = np.dtype(
    [
        ("first_record", "<u4"),
        ("place", "<u4"),  # of the first record in the bound block
        ("count", "<u4"),
        ("tile", "<u4"),
        ("depth_row", "<f4", 4),
    ]
)
BINDINGS = ("RECORDS", "SLICES", "KEYS_IN", "VALUES_IN", "KEYS_OUT", "VALUES_OUT", "COUNTS", "TILE_COUNTS")
# GL promises eight bindings; STATE is never in one shader with RECORDS.
BINDING_NUMBERS = {name: number for number, name in enumerate(BINDINGS)} | {"STATE": 0}
DEFINES: dict[str, Define] = {
    **BINDING_NUMBERS,
    "DIGIT_BITS": DIGIT_BITS,
    "RADIX": RADIX,
    "PASSES": PASSES,
    "THREADS": THREADS,
    "TILE": TILE,
    "INT16_STEPS": INT16_STEPS,
}


@dataclass(frozen=True, eq=False)
class SurfelCull:
    """What the cull of single surfels needs to know of a frame.

    Attributes:
        levels: texture of `blocks.BlockTexture`, views of this frame included.
        size_px: (width, height) of the image.
        modulated: whether Eq. 3 applies; False where w = 1 is certain.
        contribution_min: surfels whose opacity times area, px^2, is less are not drawn.
    """

    levels: moderngl.Texture
    size_px: tuple[int, int]
    modulated: bool = True
    contribution_min: float = 0.0


@dataclass(frozen=True, eq=False)
class GpuOrder:
    """An order that lives on the GPU, valid until the next one of the same `ComputeOrder`.

    Attributes:
        index: uint32 record numbers, farthest first, as an element index.
        indirect: starts with one DrawElementsIndirect command over them.
        capacity: bound of the number of records.
    """

    index: moderngl.Buffer
    indirect: moderngl.Buffer
    capacity: int

    def count(self) -> int:
        """Reads how many records there are; waits for the GPU."""
        return int(np.frombuffer(self.indirect.read(4), np.uint32)[0])

    def read(self) -> UIntArray:
        """Reads the record numbers, farthest first, (n,); waits for the GPU."""
        count = self.count()
        return np.frombuffer(self.index.read(4 * count) if count else b"", np.uint32)


@dataclass(frozen=True)
class Window:
    """A range of the surfel buffer that fits into one storage block.

    Attributes:
        first_slice: of the slices whose records it holds.
        num_slices: how many.
        first_record: where it starts.
    """

    first_slice: int
    num_slices: int
    first_record: int


def slice_table(runs: Sequence[Run], focus: Focus) -> NDArray[Any]:
    """Cuts runs into slices of at most `TILE` surfels, (slices,) of `SLICE_DTYPE`.

    Args:
        runs: in scene order.
        focus: of the rendered view.
    """
    lengths = np.array([len(run) for run in runs], np.int64)
    num_slices = -(-lengths // TILE)
    owner = np.repeat(np.arange(len(runs)), num_slices)
    place = TILE * (np.arange(len(owner)) - np.repeat(np.cumsum(num_slices) - num_slices, num_slices))
    firsts = np.array([run.first_record for run in runs], np.int64)
    rows = np.array([run.depth_row(focus) for run in runs], np.float32).reshape(-1, 4)
    table = np.zeros(len(owner), SLICE_DTYPE)
    table["first_record"] = table["place"] = firsts[owner] + place
    table["count"] = np.minimum(lengths[owner] - place, TILE)
    table["tile"] = np.arange(len(owner))
    table["depth_row"] = rows[owner]
    return table


def windows(table: NDArray[Any], num_records: int, block_records: int) -> tuple[NDArray[Any], list[Window]]:
    """Groups slices by range of the surfel buffer.

    Args:
        table: slices.
        num_records: that the surfel buffer holds.
        block_records: that a storage block may hold, more than a slice.

    Returns:
        The slices, window by window, their places now within it (their tiles stay); and the windows.
    """
    if num_records <= block_records:
        return table, [Window(0, len(table), 0)]
    step = (block_records - TILE) // WINDOW_STEP * WINDOW_STEP  # no slice ends beyond its window
    number = table["first_record"] // step
    sequence = np.argsort(number, kind="stable")
    table = table[sequence]
    table["place"] -= number[sequence] * step
    used, firsts, counts = np.unique(number[sequence], return_index=True, return_counts=True)
    parts = zip(firsts.tolist(), counts.tolist(), used.tolist(), strict=True)
    return table, [Window(first, count, step * part) for first, count, part in parts]


class ComputeOrder:
    """Shaders and buffers of the ordering; buffers are kept and grow.

    Attributes:
        block_bytes: largest storage block, the driver's unless told otherwise.
    """

    def __init__(self, ctx: moderngl.Context, block_bytes: int | None = None) -> None:
        self.ctx = ctx
        told = int(ctx.info.get("GL_MAX_SHADER_STORAGE_BLOCK_SIZE", 0))
        self.block_bytes = block_bytes or max(told, BLOCK_FLOOR_BYTES)
        self._shaders: dict[tuple[str, ...], moderngl.ComputeShader] = {}
        self._buffers: dict[str, moderngl.Buffer] = {}

    @staticmethod
    def is_supported(ctx: moderngl.Context) -> bool:
        """Whether the context has compute shaders and storage blocks."""
        return int(ctx.version_code) >= COMPUTE_VERSION

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return sum(buffer.size for buffer in self._buffers.values())

    def fits(self, runs: Sequence[Run], records: moderngl.Buffer) -> bool:
        """Whether `order` can take these runs; where not, `gl.order` has to."""
        num_tiles = sum(-(-len(run) // TILE) for run in runs)
        if num_tiles > MAX_TILES or 4 * TILE * num_tiles > self.block_bytes:
            return False
        return records.size <= self.block_bytes or TILE + WINDOW_STEP <= self.block_bytes // RECORD_BYTES

    def order(
        self, runs: Sequence[Run], focus: Focus, records: moderngl.Buffer, cull: SurfelCull | None = None
    ) -> GpuOrder:
        """Orders the surfels of a frame.

        Args:
            runs: in scene order.
            focus: of the rendered view.
            records: the surfel buffer.
            cull: drops surfels that would draw nothing; None keeps all.

        Raises:
            ContextError: where the frame does not fit (see `fits`).
        """
        if not self.fits(runs, records):
            why = f"a frame exceeds the driver's storage blocks of {self.block_bytes >> 20} MiB"
            raise ContextError("compute order", why, "Let the CPU order it")
        table = slice_table(runs, focus)
        self._reserve(len(table))
        if len(table):
            self._make_keys(table, records, cull)
            for number in range(PASSES):
                self._sort_pass(number, len(table))
            self.ctx.memory_barrier()
        return GpuOrder(self._buffers["values"], self._buffers["state"], int(table["count"].sum()))

    def release(self) -> None:
        """Frees everything."""
        for shader in self._shaders.values():
            shader.release()
        for buffer in self._buffers.values():
            buffer.release()
        self._shaders, self._buffers = {}, {}

    # ------------------------------------------------------------- passes

    def _make_keys(self, table: NDArray[Any], records: moderngl.Buffer, cull: SurfelCull | None) -> None:
        block = self.block_bytes // RECORD_BYTES
        num_records = records.size // RECORD_BYTES
        table, parts = windows(table, num_records, block)
        self._buffers["slices"].orphan()  # the frame before may still read it
        self._buffers["slices"].write(table.tobytes())
        shader = self._keying(cull)
        names = {"SLICES": "slices", "KEYS_OUT": "keys", "VALUES_OUT": "values", "TILE_COUNTS": "tile_counts"}
        self._bind(names)
        for part in parts:
            held = min(block, num_records - part.first_record)
            offset = RECORD_BYTES * part.first_record
            records.bind_to_storage_buffer(BINDING_NUMBERS["RECORDS"], offset, RECORD_BYTES * held)
            _set(shader, {"u_first_slice": part.first_slice})
            shader.run(part.num_slices)
        self.ctx.memory_barrier(self.ctx.SHADER_STORAGE_BARRIER_BIT)

    def _keying(self, cull: SurfelCull | None) -> moderngl.ComputeShader:
        """The shader of the keys, with everything set that all windows share."""
        macros = [] if cull is None else ["CULL", "MODULATED"][: 1 + cull.modulated]
        shader = self._shader("key", *macros)
        _set(shader, {"u_steps": 1.0 / DEPTH_QUANTUM})
        if cull is not None:
            cull.levels.use(0)
            _set(shader, {"t_levels": 0, "u_size_px": cull.size_px})
            _set(shader, {"u_contribution_min": cull.contribution_min})
        return shader

    def _sort_pass(self, number: int, num_tiles: int) -> None:
        source, target = ("", "_back") if number % 2 == 0 else ("_back", "")
        self._bind({"KEYS_IN": f"keys{source}", "VALUES_IN": f"values{source}", "COUNTS": "counts"})
        self._bind({"KEYS_OUT": f"keys{target}", "VALUES_OUT": f"values{target}"})
        self._bind({"TILE_COUNTS": "tile_counts", "STATE": "state"})
        for name, groups in (("histogram", num_tiles), ("scan", RADIX), ("scatter", num_tiles)):
            shader = self._shader(name)
            _set(shader, {"u_pass": number, "u_num_slices": num_tiles})
            shader.run(groups)
            self.ctx.memory_barrier(self.ctx.SHADER_STORAGE_BARRIER_BIT)

    # ------------------------------------------------------------- objects

    def _shader(self, name: str, *macros: str) -> moderngl.ComputeShader:
        if (name, *macros) not in self._shaders:
            defines = {**DEFINES, **dict.fromkeys(macros, True)}
            self._shaders[name, *macros] = load_compute(self.ctx, f"order/{name}.comp", defines)
        return self._shaders[name, *macros]

    def _reserve(self, num_tiles: int) -> None:
        keys, tiles = 4 * TILE * max(num_tiles, 1), 4 * max(num_tiles, 1)
        sizes = dict.fromkeys(("keys", "keys_back", "values", "values_back"), keys)
        sizes |= {"slices": SLICE_DTYPE.itemsize * max(num_tiles, 1)}
        sizes |= {"tile_counts": tiles, "counts": RADIX * tiles, "state": 4 * STATE_WORDS}
        for name, size in sizes.items():
            if name not in self._buffers or self._buffers[name].size < size:
                self._replace(name, size)
        if not num_tiles:
            self._buffers["state"].write(_command())

    def _replace(self, name: str, size: int) -> None:
        former = self._buffers.pop(name, None)
        if former is not None:
            former.release()
            size = max(size, min(int(size * GROWTH) // 4 * 4, self.block_bytes))
        self._buffers[name] = self.ctx.buffer(reserve=size, dynamic=True)
        if name == "state":
            self._buffers[name].write(_command())

    def _bind(self, names: Mapping[str, str]) -> None:
        for block, name in names.items():
            buffer = self._buffers[name]
            size = min(buffer.size, self.block_bytes)
            buffer.bind_to_storage_buffer(BINDING_NUMBERS[block], 0, size)


def _command() -> bytes:
    """A draw of nothing: count, instances, first index, base vertex, base instance."""
    return np.array([0, 1, 0, 0, 0], np.uint32).tobytes()


def _set(shader: moderngl.ComputeShader, values: Mapping[str, Any]) -> None:
    for name, value in values.items():
        if name in shader:  # a variant may have no use for some
            shader[name] = value
