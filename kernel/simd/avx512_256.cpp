// AVX-512 on vectors of 32 bytes, for its 32 registers; see levels.cpp for where that is fastest.
#define RCAC_LEVEL avx512_256
#define RCAC_WIDTH 4
#include "simd/lanes/loop.inl.hpp"
#include "simd/symmetric.inl.hpp"
#include "simd/lanes/ud.inl.hpp"
#include "simd/ud_rank_one.inl.hpp"

namespace rcac {

extern const Level level_avx512_256;
const Level level_avx512_256{"avx512-256",
                             &avx512_256::ud_rank_one,
                             &avx512_256::ud_measure,
                             &avx512_256::symmetric_measure,
                             &avx512_256::lanes_rank_one,
                             &avx512_256::lanes_measure,
                             &avx512_256::lane_steps,
                             &avx512_256::finite};

}  // namespace rcac
