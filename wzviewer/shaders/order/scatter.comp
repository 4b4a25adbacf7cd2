// One stable pass of the radix sort: every key goes behind all keys of lower digits and all earlier
// keys of its own digit.
//
// in:  keys, values, prefix sums of the counts      out: keys, values in the order of the digit
//
// Rank within a tile: stripe by stripe of THREADS keys, each key sets its invocation's bit in its
// digit's mask; set bits below its own are its rank in the stripe.  Two masks alternate, so that a
// stripe needs two barriers.  The tile is then sorted in shared memory first, so that neighbours
// in memory are written by neighbouring invocations.

#include "scan.glsl"
#include "tiles.glsl"

layout(local_size_x = THREADS) in;

layout(std430, binding = KEYS_IN) readonly buffer KeysIn { uint keys_in[]; };
layout(std430, binding = VALUES_IN) readonly buffer ValuesIn { uint values_in[]; };
layout(std430, binding = KEYS_OUT) writeonly buffer KeysOut { uint keys_out[]; };
layout(std430, binding = VALUES_OUT) writeonly buffer ValuesOut { uint values_out[]; };
layout(std430, binding = COUNTS) readonly buffer Counts { uint counts[]; };

const uint WORDS = THREADS / 32u;  // of a digit's mask

shared uint s_words[2u * TILE];  // masks [2][WORDS][RADIX]; later the sorted keys and values
shared uint s_seen[RADIX];       // keys of each digit in the stripes so far
shared uint s_local[RADIX];      // where a digit starts in the sorted tile
shared uint s_shift[RADIX];      // from there to its place in the output

// Keys of the same digit below this one in the stripe (x) and in the whole stripe (y).
uvec2 rank_in_stripe(uint mask, uint digit) {
    uint t = gl_LocalInvocationID.x;
    uvec2 rank = uvec2(0u);
    for (uint w = 0u; w < WORDS; ++w) {
        uint word = s_words[mask + w * RADIX + digit];
        uint below = w < (t >> 5) ? word : (w == (t >> 5) ? word & ((1u << (t & 31u)) - 1u) : 0u);
        rank += uvec2(bitCount(below), bitCount(word));
    }
    return rank;
}

// Rank of a key among those of its digit in the tile; `mask` alternates between the stripes.
uint ranked(uint mask, uint digit, bool valid) {
    uint t = gl_LocalInvocationID.x;
    if (valid) atomicOr(s_words[mask + (t >> 5) * RADIX + digit], 1u << (t & 31u));
    sync();
    uvec2 rank = valid ? rank_in_stripe(mask, digit) : uvec2(0u);
    uint before = s_seen[digit];
    sync();
    if (valid && rank.x + 1u == rank.y) {  // the last of its digit tidies up
        s_seen[digit] = before + rank.y;
        for (uint w = 0u; w < WORDS; ++w) s_words[mask + w * RADIX + digit] = 0u;
    }
    return before + rank.x;
}

// Fills s_local and s_shift; the sum of the totals is the number of keys.
void place_digits(uint tile, uint tiles) {
    uint t = gl_LocalInvocationID.x;
    uvec2 start = exclusive_scan(uvec2(totals[t], s_seen[t]));
    s_local[t] = start.y;
    s_shift[t] = start.x + counts[t * tiles + tile] - start.y;
    if (u_pass == 0u && tile == 0u && t == RADIX - 1u) command[0] = start.x + totals[t];
    sync();
}

void main() {
    uint t = gl_LocalInvocationID.x;
    uint tile = gl_WorkGroupID.x;
    uint tiles = num_tiles();
    if (tile >= tiles) return;
    uint n = tile_count(tile);
    for (uint i = t; i < 2u * TILE; i += THREADS) s_words[i] = 0u;
    s_seen[t] = 0u;
    sync();

    uint keys[TILE / THREADS], values[TILE / THREADS], ranks[TILE / THREADS];
    for (uint j = 0u; j < TILE / THREADS; ++j) {
        uint i = j * THREADS + t;
        bool valid = i < n;
        keys[j] = valid ? keys_in[tile * TILE + i] : 0u;
        values[j] = valid ? values_in[tile * TILE + i] : 0u;
        ranks[j] = ranked((j & 1u) * WORDS * RADIX, digit_of(keys[j]), valid);
    }
    sync();
    place_digits(tile, tiles);

    for (uint j = 0u; j < TILE / THREADS; ++j) {
        if (j * THREADS + t >= n) continue;
        uint at = s_local[digit_of(keys[j])] + ranks[j];
        s_words[at] = keys[j];
        s_words[TILE + at] = values[j];
    }
    sync();
    bool last = u_pass == PASSES - 1u;
    for (uint i = t; i < n; i += THREADS) {
        uint key = s_words[i];
        uint target = s_shift[digit_of(key)] + i;
        if (last) target = command[0] - 1u - target;  // farthest first
        values_out[target] = s_words[TILE + i];
        if (!last) keys_out[target] = key;
    }
}
