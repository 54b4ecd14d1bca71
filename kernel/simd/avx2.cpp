// AVX2 with fused multiply-add: vectors of 32 bytes.
#define RCAC_INSTRUCTION_SET avx2
#define RCAC_WIDTH 4
#include "simd/dispatch.hpp"
#include "simd/lanes/loop.inl.hpp"
#include "simd/lanes/ud.inl.hpp"
#include "simd/triangular.inl.hpp"
#include "simd/ud_rank_one.inl.hpp"

namespace rcac {

extern const InstructionSet set_avx2;
const InstructionSet set_avx2{
    "avx2",
    &avx2::ud_measure,
    &avx2::lanes_rank_one,
    &avx2::lanes_measure,
    &avx2::lane_steps,
    &avx2::finite,
    &avx2::transposed_times,
    &avx2::times,
    &avx2::dot,
    &avx2::growth,
};

}  // namespace rcac
