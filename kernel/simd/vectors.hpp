// Short vectors of doubles whose width is that of the instruction set a file is compiled for.
//
// Included only by the files that are compiled once per instruction set. Each defines
// RCAC_INSTRUCTION_SET, the namespace that keeps its copy of every function apart from the others',
// and RCAC_WIDTH, the doubles in one vector.
// Nothing here may include a header with inline functions: the linker would be free to keep the
// copy compiled for the widest vectors and to call it on every processor.
#pragma once

#include <cstddef>

namespace rcac::RCAC_INSTRUCTION_SET {

constexpr std::size_t width = RCAC_WIDTH;
constexpr std::size_t tile = 8;                // rows and columns of a tile, for every width
constexpr std::size_t parts = tile / width;    // vectors in one column of a tile

#if defined(__GNUC__) || defined(__clang__)
#define RCAC_INLINE inline __attribute__((always_inline))
#define RCAC_RESTRICT __restrict__
// Before a loop over registers, whose numbers must be known where it is compiled.
#if defined(__clang__)
#define RCAC_UNROLL _Pragma("clang loop unroll(full)")
#else
#define RCAC_UNROLL _Pragma("GCC unroll 32")
#endif

typedef double Vec __attribute__((vector_size(8 * RCAC_WIDTH)));
// The same vector at any address that a double may have.
typedef double Loose __attribute__((vector_size(8 * RCAC_WIDTH), aligned(8), may_alias));

RCAC_INLINE Vec load(const double* p) { return *reinterpret_cast<const Loose*>(p); }
RCAC_INLINE void store(double* p, Vec a) { *reinterpret_cast<Loose*>(p) = a; }
RCAC_INLINE Vec all(double x) { return x - Vec{}; }  // not Vec{} + x, which would turn -0 into 0
RCAC_INLINE Vec larger(Vec a, Vec b) { return a > b ? a : b; }
RCAC_INLINE Vec where_zero(Vec x, Vec yes, Vec no) { return x == Vec{} ? yes : no; }

#else  // a compiler without vector extensions gets loops that it may vectorise
#define RCAC_INLINE inline
#define RCAC_RESTRICT __restrict
#define RCAC_UNROLL

struct Vec {
    double lane[RCAC_WIDTH];
    double operator[](std::size_t i) const { return lane[i]; }
    double& operator[](std::size_t i) { return lane[i]; }
    Vec operator-() const {
        Vec c;
        for (std::size_t i = 0; i < width; ++i) c.lane[i] = -lane[i];
        return c;
    }
};
#define RCAC_OPERATOR(op)                                                        \
    inline Vec operator op(const Vec& a, const Vec& b) {                         \
        Vec c;                                                                   \
        for (std::size_t i = 0; i < width; ++i) c.lane[i] = a.lane[i] op b.lane[i]; \
        return c;                                                                \
    }
RCAC_OPERATOR(+)
RCAC_OPERATOR(-)
RCAC_OPERATOR(*)
RCAC_OPERATOR(/)
#undef RCAC_OPERATOR
inline Vec load(const double* p) {
    Vec a;
    for (std::size_t i = 0; i < width; ++i) a.lane[i] = p[i];
    return a;
}
inline void store(double* p, const Vec& a) {
    for (std::size_t i = 0; i < width; ++i) p[i] = a.lane[i];
}
inline Vec all(double x) {
    Vec a;
    for (std::size_t i = 0; i < width; ++i) a.lane[i] = x;
    return a;
}
inline Vec larger(Vec a, const Vec& b) {
    for (std::size_t i = 0; i < width; ++i) a[i] = a[i] > b[i] ? a[i] : b[i];
    return a;
}
inline Vec where_zero(const Vec& x, const Vec& yes, Vec no) {
    for (std::size_t i = 0; i < width; ++i) no[i] = x[i] == 0.0 ? yes[i] : no[i];
    return no;
}
#endif

RCAC_INLINE double magnitude(double x) { return x < 0.0 ? -x : x; }
RCAC_INLINE Vec zero() { return all(0.0); }

// Where the compiler can name a shuffle, sums across lanes take log2(width) steps.
#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define RCAC_SHUFFLE 1
#endif
#endif

// Lane c of the result is the sum of all lanes of a[c].
RCAC_INLINE Vec sums_of(const Vec* a) {
#if defined(RCAC_SHUFFLE) && RCAC_WIDTH == 8
    Vec b[4], c[2];
    for (int i = 0; i < 4; ++i)
        b[i] = __builtin_shufflevector(a[2 * i], a[2 * i + 1], 0, 8, 2, 10, 4, 12, 6, 14) +
               __builtin_shufflevector(a[2 * i], a[2 * i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    for (int i = 0; i < 2; ++i)  // lanes 0, 1, 2, 3 of a, then once more for the other half
        c[i] = __builtin_shufflevector(b[2 * i], b[2 * i + 1], 0, 1, 8, 9, 4, 5, 12, 13) +
               __builtin_shufflevector(b[2 * i], b[2 * i + 1], 2, 3, 10, 11, 6, 7, 14, 15);
    return __builtin_shufflevector(c[0], c[1], 0, 1, 2, 3, 8, 9, 10, 11) +
           __builtin_shufflevector(c[0], c[1], 4, 5, 6, 7, 12, 13, 14, 15);
#elif defined(RCAC_SHUFFLE) && RCAC_WIDTH == 4
    Vec b[2];
    for (int i = 0; i < 2; ++i)
        b[i] = __builtin_shufflevector(a[2 * i], a[2 * i + 1], 0, 4, 2, 6) +
               __builtin_shufflevector(a[2 * i], a[2 * i + 1], 1, 5, 3, 7);
    return __builtin_shufflevector(b[0], b[1], 0, 1, 4, 5) +
           __builtin_shufflevector(b[0], b[1], 2, 3, 6, 7);
#else
    Vec result = zero();
    for (std::size_t c = 0; c < width; ++c) {
        double sum = a[c][0];
        for (std::size_t i = 1; i < width; ++i) sum += a[c][i];
        result[c] = sum;
    }
    return result;
#endif
}

// Lane c of a in every lane; c is known where this is compiled.
RCAC_INLINE Vec spread_lane(Vec a, std::size_t c) {
#if defined(RCAC_SHUFFLE) && RCAC_WIDTH == 4
    return c == 0   ? __builtin_shufflevector(a, a, 0, 0, 0, 0)
           : c == 1 ? __builtin_shufflevector(a, a, 1, 1, 1, 1)
           : c == 2 ? __builtin_shufflevector(a, a, 2, 2, 2, 2)
                    : __builtin_shufflevector(a, a, 3, 3, 3, 3);
#elif defined(RCAC_SHUFFLE) && RCAC_WIDTH == 2
    return c == 0 ? __builtin_shufflevector(a, a, 0, 0) : __builtin_shufflevector(a, a, 1, 1);
#else
    return all(a[c]);
#endif
}

// One step of a reduction across the lanes: lane i and the one `width >> step` further.
RCAC_INLINE Vec folded_over(Vec a, int step) {
#if defined(RCAC_SHUFFLE) && RCAC_WIDTH == 8
    return step == 1   ? __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3)
           : step == 2 ? __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5)
                       : __builtin_shufflevector(a, a, 1, 0, 3, 2, 5, 4, 7, 6);
#elif defined(RCAC_SHUFFLE) && RCAC_WIDTH == 4
    return step == 1 ? __builtin_shufflevector(a, a, 2, 3, 0, 1)
                     : __builtin_shufflevector(a, a, 1, 0, 3, 2);
#else
    const Vec b = a;
    for (std::size_t i = 0; i < width; ++i) a[i] = b[i ^ (width >> step)];
    return a;
#endif
}

RCAC_INLINE double sum_of(Vec a) {
    for (int step = 1; (width >> step) > 0; ++step) a = a + folded_over(a, step);
    return a[0];
}

RCAC_INLINE double largest_of(Vec a) {
    for (int step = 1; (width >> step) > 0; ++step) a = larger(folded_over(a, step), a);
    return a[0];
}

// Lane c of the result is a[0] + ... + a[c].
RCAC_INLINE Vec running_sums(Vec a) {
#if defined(RCAC_SHUFFLE) && RCAC_WIDTH == 8
    const Vec o = zero();
    a = a + __builtin_shufflevector(o, a, 0, 8, 9, 10, 11, 12, 13, 14);
    a = a + __builtin_shufflevector(o, a, 0, 0, 8, 9, 10, 11, 12, 13);
    return a + __builtin_shufflevector(o, a, 0, 0, 0, 0, 8, 9, 10, 11);
#elif defined(RCAC_SHUFFLE) && RCAC_WIDTH == 4
    const Vec o = zero();
    a = a + __builtin_shufflevector(o, a, 0, 4, 5, 6);
    return a + __builtin_shufflevector(o, a, 0, 0, 4, 5);
#else
    for (std::size_t c = 1; c < width; ++c) a[c] = a[c - 1] + a[c];
    return a;
#endif
}

// a moved up by one lane, the last lane of `before` in lane 0.
RCAC_INLINE Vec moved_up(Vec a, Vec before) {
#if defined(RCAC_SHUFFLE) && RCAC_WIDTH == 8
    return __builtin_shufflevector(before, a, 7, 8, 9, 10, 11, 12, 13, 14);
#elif defined(RCAC_SHUFFLE) && RCAC_WIDTH == 4
    return __builtin_shufflevector(before, a, 3, 4, 5, 6);
#else
    const double first = before[width - 1];
    for (std::size_t c = width; c-- > 1;) a[c] = a[c - 1];
    a[0] = first;
    return a;
#endif
}

}  // namespace rcac::RCAC_INSTRUCTION_SET
