#include "simd/levels.hpp"

#include <cstring>
#include <stdexcept>
#include <string>

#if defined(RCAC_X86_LEVELS)
#include <cpuid.h>
#endif

namespace rcac {

extern const Level level_plain;
#if defined(RCAC_X86_LEVELS)
extern const Level level_avx2, level_avx512_256, level_avx512;
#endif

namespace {

struct Found {
    Level mixed;
    const Level* list[4];
    std::size_t count = 0;
    Found();
    void add(const Level& level) { list[count++] = &level; }
};

#if defined(RCAC_X86_LEVELS)
// Zen 4 (AMD family 19h) knows AVX-512 but stores 64 bytes more slowly than twice 32, and crosses
// the lanes of 64 bytes slowly: a single run is fastest there with vectors of 4 doubles and
// AVX-512's 32 registers, several in lock step with 8.
bool halves_wide_stores() {
    unsigned a = 0, b = 0, c = 0, d = 0;
    if (!__get_cpuid(0, &a, &b, &c, &d) || b != signature_AMD_ebx) return false;
    __get_cpuid(1, &a, &b, &c, &d);
    return ((a >> 8) & 0xf) + ((a >> 20) & 0xff) == 0x19;
}
#endif

Found::Found() : mixed(level_plain) {
#if defined(RCAC_X86_LEVELS)
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    if (avx512 && halves_wide_stores()) {
        mixed = level_avx512_256;
        mixed.lanes_rank_one = level_avx512.lanes_rank_one;
        mixed.lanes_measure = level_avx512.lanes_measure;
        mixed.lane_steps = level_avx512.lane_steps;
        add(mixed);
        add(level_avx512);
    } else if (avx512) {
        add(level_avx512);
        add(level_avx512_256);
    }
    if (avx2) add(level_avx2);
#endif
    add(level_plain);
}

}  // namespace

Levels levels() {
    static const Found found;
    return {found.list, found.count};
}

const Level& level(const char* name) {
    const Levels all = levels();
    if (!*name) return *all.first[0];
    for (std::size_t i = 0; i < all.count; ++i)
        if (std::strcmp(all.first[i]->name, name) == 0) return *all.first[i];
    throw std::invalid_argument(std::string("no instruction set named ") + name +
                                " on this processor");
}

}  // namespace rcac
