// AVX-512 on vectors of 32 bytes, for its 32 registers; see dispatch.cpp for where that is fastest.
#define RCAC_INSTRUCTION_SET avx512_256
#define RCAC_WIDTH 4
#include "simd/dispatch.hpp"
#include "simd/lanes/loop.inl.hpp"
#include "simd/lanes/ud.inl.hpp"
#include "simd/triangular.inl.hpp"
#include "simd/ud_rank_one.inl.hpp"

namespace rcac {

extern const InstructionSet set_avx512_256;
const InstructionSet set_avx512_256{
    "avx512-256",
    &avx512_256::ud_measure,
    &avx512_256::lanes_rank_one,
    &avx512_256::lanes_measure,
    &avx512_256::lane_steps,
    &avx512_256::finite,
    &avx512_256::transposed_times,
    &avx512_256::times,
    &avx512_256::dot,
    &avx512_256::growth,
};

}  // namespace rcac
