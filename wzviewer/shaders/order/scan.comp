// Exclusive sums along the rows of counts[digit][tile], one workgroup per digit, and the row totals.

#include "scan.glsl"
#include "tiles.glsl"

layout(local_size_x = THREADS) in;

layout(std430, binding = COUNTS) buffer Counts { uint counts[]; };

void main() {
    uint t = gl_LocalInvocationID.x;
    uint digit = gl_WorkGroupID.x;
    uint tiles = num_tiles();
    uint share = (tiles + THREADS - 1u) / THREADS;  // consecutive tiles per invocation
    uint first = digit * tiles + min(t * share, tiles);
    uint last = digit * tiles + min((t + 1u) * share, tiles);

    uint sum = 0u;
    for (uint i = first; i < last; ++i) sum += counts[i];
    uint before = exclusive_scan(uvec2(sum, 0u)).x;
    if (t == THREADS - 1u) totals[digit] = before + sum;
    for (uint i = first; i < last; ++i) {
        uint count = counts[i];
        counts[i] = before;
        before += count;
    }
}
