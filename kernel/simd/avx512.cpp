// AVX-512: vectors of 64 bytes.
#define RCAC_LEVEL avx512
#define RCAC_WIDTH 8
#include "simd/lanes/loop.inl.hpp"
#include "simd/symmetric.inl.hpp"
#include "simd/lanes/ud.inl.hpp"
#include "simd/ud_rank_one.inl.hpp"

namespace rcac {

extern const Level level_avx512;
const Level level_avx512{"avx512",
                         &avx512::ud_rank_one,
                         &avx512::ud_measure,
                         &avx512::symmetric_measure,
                         &avx512::lanes_rank_one,
                         &avx512::lanes_measure,
                         &avx512::lane_steps,
                         &avx512::finite};

}  // namespace rcac
