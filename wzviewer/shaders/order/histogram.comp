// Keys by digit, tile by tile.
//
// in:  keys      out: counts[digit][tile]

#include "scan.glsl"
#include "tiles.glsl"

layout(local_size_x = THREADS) in;

layout(std430, binding = KEYS_IN) readonly buffer KeysIn { uint keys_in[]; };
layout(std430, binding = COUNTS) writeonly buffer Counts { uint counts[]; };

shared uint s_counts[RADIX];

void main() {
    uint t = gl_LocalInvocationID.x;
    uint tile = gl_WorkGroupID.x;
    uint tiles = num_tiles();
    if (tile >= tiles) return;
    uint n = tile_count(tile);
    s_counts[t] = 0u;
    sync();
    for (uint i = t; i < n; i += THREADS) atomicAdd(s_counts[digit_of(keys_in[tile * TILE + i])], 1u);
    sync();
    counts[t * tiles + tile] = s_counts[t];
}
