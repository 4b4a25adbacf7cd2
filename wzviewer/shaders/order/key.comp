// Sort keys of one slice: consecutive records of a run of gl/order.py, one workgroup per slice.
//
// in:  records, slices      out: keys and record numbers of the survivors, at the front of the
//                                slice's tile and in scene order, and how many they are
// The key is relative_depths then sortable_bits, operation by operation.

#include "scan.glsl"

layout(local_size_x = THREADS) in;

struct Slice {
    uint first_record;
    uint place;  // of it in the bound block
    uint count;
    uint tile;
    vec4 depth_row;  // of a position and 1: depth behind the focus, its px
};

layout(std430, binding = RECORDS) readonly buffer Records { uvec4 halves[]; };  // two per record
layout(std430, binding = SLICES) readonly buffer Slices { Slice slices[]; };
layout(std430, binding = KEYS_OUT) writeonly buffer KeysOut { uint keys_out[]; };
layout(std430, binding = VALUES_OUT) writeonly buffer ValuesOut { uint values_out[]; };
layout(std430, binding = TILE_COUNTS) writeonly buffer TileCounts { uint tile_counts[]; };

uniform uint u_first_slice;
uniform float u_steps;  // quanta per pixel of the focus

#ifdef CULL
#include "visible.glsl"
#endif

shared uint s_alive[TILE / 32];
shared uint s_before[TILE / 32];  // survivors before each word

uint key_of(vec4 row, vec3 mean) {
    precise float depth = row.x * mean.x;  // a fused multiply-add would round once less
    depth += row.y * mean.y;
    depth += row.z * mean.z;
    depth += row.w;
    depth *= u_steps;
    uint bits = floatBitsToUint(roundEven(depth));
    if (bits == 0x80000000u) bits = 0u;  // -0 would sort below +0
    return bits ^ ((bits >> 31) != 0u ? 0xFFFFFFFFu : 0x80000000u);
}

void main() {
    uint t = gl_LocalInvocationID.x;
    Slice s = slices[u_first_slice + gl_WorkGroupID.x];
    if (t < TILE / 32) s_alive[t] = 0u;
    sync();

    uint keys[TILE / THREADS];
    for (uint j = 0u; j < TILE / THREADS; ++j) {
        uint place = j * THREADS + t;
        if (place >= s.count) continue;
        uint at = 2u * (s.place + place);
        uvec4 head = halves[at];
        keys[j] = key_of(s.depth_row, uintBitsToFloat(head.xyz));
#ifdef CULL
        if (!is_visible(head, halves[at + 1u])) continue;
#endif
        atomicOr(s_alive[place >> 5], 1u << (place & 31u));
    }
    sync();

    uint alive = t < TILE / 32 ? bitCount(s_alive[t]) : 0u;
    uint before = exclusive_scan(uvec2(alive, 0u)).x;
    if (t < TILE / 32) s_before[t] = before;
    if (t == THREADS - 1u) tile_counts[s.tile] = before + alive;
    sync();

    for (uint j = 0u; j < TILE / THREADS; ++j) {
        uint place = j * THREADS + t;
        uint word = s_alive[place >> 5];
        uint bit = 1u << (place & 31u);
        if ((word & bit) == 0u) continue;
        uint target = s.tile * TILE + s_before[place >> 5] + bitCount(word & (bit - 1u));
        keys_out[target] = keys[j];
        values_out[target] = s.first_record + place;
    }
}
