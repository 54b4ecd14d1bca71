// AVX-512: vectors of 64 bytes.
#define RCAC_INSTRUCTION_SET avx512
#define RCAC_WIDTH 8
#include "simd/dispatch.hpp"
#include "simd/lanes/loop.inl.hpp"
#include "simd/lanes/ud.inl.hpp"
#include "simd/triangular.inl.hpp"
#include "simd/ud_rank_one.inl.hpp"

namespace rcac {

extern const InstructionSet set_avx512;
const InstructionSet set_avx512{
    "avx512",
    &avx512::ud_measure,
    &avx512::lanes_rank_one,
    &avx512::lanes_measure,
    &avx512::lane_steps,
    &avx512::finite,
    &avx512::transposed_times,
    &avx512::times,
    &avx512::dot,
    &avx512::growth,
};

}  // namespace rcac
