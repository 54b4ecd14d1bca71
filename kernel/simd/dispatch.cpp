#include "simd/dispatch.hpp"

#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

#if defined(RCAC_X86_INSTRUCTION_SETS)
#include <cpuid.h>
#endif

namespace rcac {

extern const InstructionSet set_plain;
#if defined(RCAC_X86_INSTRUCTION_SETS)
extern const InstructionSet set_avx2, set_avx512_256, set_avx512;
#endif

namespace {

struct Found {
    InstructionSet mixed;
    const InstructionSet* list[4];
    std::size_t count = 0;
    Found();
    void add(const InstructionSet& instructions) { list[count++] = &instructions; }
};

#if defined(RCAC_X86_INSTRUCTION_SETS)
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

Found::Found() : mixed(set_plain) {
#if defined(RCAC_X86_INSTRUCTION_SETS)
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    if (avx512 && halves_wide_stores()) {
        mixed = set_avx512_256;
        mixed.lanes_rank_one = set_avx512.lanes_rank_one;
        mixed.lanes_measure = set_avx512.lanes_measure;
        mixed.lane_steps = set_avx512.lane_steps;
        add(mixed);
        add(set_avx512);
    } else if (avx512) {
        add(set_avx512);
        add(set_avx512_256);
    }
    if (avx2) add(set_avx2);
#endif
    add(set_plain);
}

}  // namespace

InstructionSets instruction_sets() {
    static const Found found;
    return {found.list, found.count};
}

const InstructionSet& instruction_set(const char* name) {
    const InstructionSets all = instruction_sets();
    // Asked each time: it costs nothing beside a step, and a test may change it.
    const char* forced = std::getenv("RCAC_INSTRUCTION_SET");
    if (!*name && forced) name = forced;
    if (!*name) return *all.first[0];
    for (std::size_t i = 0; i < all.count; ++i)
        if (std::strcmp(all.first[i]->name, name) == 0) return *all.first[i];
    throw std::invalid_argument(std::string("no instruction set named ") + name +
                                " on this processor");
}

}  // namespace rcac
