// Prefix sums over a workgroup of THREADS invocations, without subgroup operations.

shared uvec2 s_scan[2][THREADS];

// Execution and shared memory.
void sync() {
    memoryBarrierShared();
    barrier();
}

// Sums of the values of all lower invocations, both components at once; uniform control flow only.
uvec2 exclusive_scan(uvec2 value) {
    uint t = gl_LocalInvocationID.x;
    uvec2 sum = value;
    uint at = 0u;
    s_scan[at][t] = sum;
    for (uint reach = 1u; reach < THREADS; reach *= 2u) {
        sync();
        if (t >= reach) sum += s_scan[at][t - reach];
        at ^= 1u;
        s_scan[at][t] = sum;
    }
    sync();  // the next scan may write at once
    return sum - value;
}
