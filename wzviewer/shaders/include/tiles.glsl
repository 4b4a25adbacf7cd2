// Which keys a workgroup of the radix sort owns: twin of gl/compute.py.
//
// Pass 0 reads what key.comp left: one tile per slice, filled as far as its survivors go.  Later
// passes read the dense result of the pass before them, whose length only the GPU knows.

layout(std430, binding = TILE_COUNTS) readonly buffer TileCounts { uint tile_counts[]; };
layout(std430, binding = STATE) buffer State {
    uint command[8];  // DrawElementsIndirect: count, instances, first index, base vertex, base instance
    uint totals[RADIX];  // keys by digit
};

uniform uint u_pass;
uniform uint u_num_slices;

uint num_tiles() {
    return u_pass == 0u ? u_num_slices : (command[0] + TILE - 1u) / TILE;
}

// Keys in a tile below num_tiles().
uint tile_count(uint tile) {
    return u_pass == 0u ? tile_counts[tile] : min(command[0] - tile * TILE, uint(TILE));
}

uint digit_of(uint key) {
    return (key >> (DIGIT_BITS * u_pass)) & (RADIX - 1u);
}
