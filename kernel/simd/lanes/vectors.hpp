// Arithmetic on one number of each lane, whatever the width of a vector.
#pragma once

#include "simd/layout.hpp"
#include "simd/vectors.hpp"

namespace rcac::RCAC_INSTRUCTION_SET {

// One number of each lane.
struct Lanes {
    Vec part[lanes / width];
};
#define RCAC_LANES for (std::size_t i = 0; i < lanes / width; ++i)
RCAC_INLINE Lanes lanes_of(const double* p) {
    Lanes a;
    RCAC_LANES a.part[i] = load(p + i * width);
    return a;
}
RCAC_INLINE void keep(double* p, const Lanes& a) { RCAC_LANES store(p + i * width, a.part[i]); }
RCAC_INLINE Lanes zeros() {
    Lanes a;
    RCAC_LANES a.part[i] = zero();
    return a;
}
RCAC_INLINE Lanes operator+(Lanes a, const Lanes& b) {
    RCAC_LANES a.part[i] = a.part[i] + b.part[i];
    return a;
}
RCAC_INLINE Lanes operator-(Lanes a, const Lanes& b) {
    RCAC_LANES a.part[i] = a.part[i] - b.part[i];
    return a;
}
RCAC_INLINE Lanes operator*(Lanes a, const Lanes& b) {
    RCAC_LANES a.part[i] = a.part[i] * b.part[i];
    return a;
}
RCAC_INLINE Lanes operator/(Lanes a, const Lanes& b) {
    RCAC_LANES a.part[i] = a.part[i] / b.part[i];
    return a;
}
RCAC_INLINE Lanes larger_size(const Lanes& a, Lanes b) {
    RCAC_LANES b.part[i] = larger(larger(a.part[i], -a.part[i]), b.part[i]);
    return b;
}
RCAC_INLINE Lanes larger_of(const Lanes& a, Lanes b) {
    RCAC_LANES b.part[i] = larger(a.part[i], b.part[i]);
    return b;
}
#undef RCAC_LANES

}  // namespace rcac::RCAC_INSTRUCTION_SET
