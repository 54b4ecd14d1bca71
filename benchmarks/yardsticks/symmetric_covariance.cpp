// The covariance recursion (2.42)-(2.45) on one triangle of P, as fast as this project can write it.
//
// The pass that computes P phi also carries out the rank-one update of the measurement before:
// every entry is loaded and stored once per measurement, with three multiply-adds. This is the
// least that a covariance form can do and therefore the yardstick of the factorised update's speed.
// It is no safer than the printed text where R_theta is small: entries of P are still differences.
//
// Compiled by symmetric_covariance.py for the processor it runs on; GCC and Clang know the vectors.
#include <cstddef>
#include <cstring>
#include <new>

namespace {

#if defined(__AVX512F__)
constexpr std::size_t width = 8;
#elif defined(__AVX__)
constexpr std::size_t width = 4;
#else
constexpr std::size_t width = 2;
#endif
typedef double Vec __attribute__((vector_size(8 * width)));
typedef double Loose __attribute__((vector_size(8 * width), aligned(8), may_alias));

#define INLINE inline __attribute__((always_inline))

INLINE Vec load(const double* p) { return *reinterpret_cast<const Loose*>(p); }
INLINE void store(double* p, Vec a) { *reinterpret_cast<Loose*>(p) = a; }
INLINE Vec all(double x) { return x - Vec{}; }
INLINE double sum_of(Vec a) {
    double sum = 0.0;
    for (std::size_t i = 0; i < width; ++i) sum += a[i];
    return sum;
}

// Lane c of the result is the sum of all lanes of a[c].
INLINE Vec sums_of(const Vec* a) {
#if defined(__AVX512F__)
    Vec b[4], c[2];
    for (int i = 0; i < 4; ++i)
        b[i] = __builtin_shufflevector(a[2 * i], a[2 * i + 1], 0, 8, 2, 10, 4, 12, 6, 14) +
               __builtin_shufflevector(a[2 * i], a[2 * i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    for (int i = 0; i < 2; ++i)
        c[i] = __builtin_shufflevector(b[2 * i], b[2 * i + 1], 0, 1, 8, 9, 4, 5, 12, 13) +
               __builtin_shufflevector(b[2 * i], b[2 * i + 1], 2, 3, 10, 11, 6, 7, 14, 15);
    return __builtin_shufflevector(c[0], c[1], 0, 1, 2, 3, 8, 9, 10, 11) +
           __builtin_shufflevector(c[0], c[1], 4, 5, 6, 7, 12, 13, 14, 15);
#else
    Vec sums;
    for (std::size_t c = 0; c < width; ++c) sums[c] = sum_of(a[c]);
    return sums;
#endif
}

// The upper triangle is cut into tiles of 8 x 8: block column by block column, inside it from the
// top down to the tile on the diagonal, which is stored in full, inside a tile column by column.
constexpr std::size_t tile = 8, parts = tile / width;

std::size_t place(std::size_t i, std::size_t j) {
    const std::size_t I = i / tile, J = j / tile;
    return ((J * (J + 1) / 2 + I) * tile + j % tile) * tile + i % tile;
}

struct Aligned {  // zeros that start at a cache line
    explicit Aligned(std::size_t count)
        : data(static_cast<double*>(::operator new(count * sizeof(double), std::align_val_t{64}))) {
        std::memset(data, 0, count * sizeof(double));
    }
    ~Aligned() { ::operator delete(data, std::align_val_t{64}); }
    Aligned(const Aligned&) = delete;
    double* data;
};

// P = scale * (tiles) + coefficient * gain * gain': the last update waits for the next pass.
struct Recursion {
    explicit Recursion(std::size_t size)
        : n(size), blocks((size + tile - 1) / tile), P(blocks * (blocks + 1) / 2 * tile * tile),
          first(blocks * tile), second(blocks * tile), row(blocks * tile) {}

    std::size_t n, blocks;
    Aligned P, first, second, row;
    double *gain = first.data, *next = second.data;
    double scale = 1.0, coefficient = 0.0;

    template <bool scaled, bool diagonal>
    INLINE static void one_tile(double* __restrict entries, const double* __restrict gain,
                                const double* __restrict row, double* __restrict next, Vec scale,
                                Vec coefficient, const Vec* right_gain, const Vec* right_row,
                                Vec* sum) {
        for (std::size_t p = 0; p < parts; ++p) {
            const Vec g = load(gain + p * width), phi = load(row + p * width);
            Vec even = load(next + p * width), odd = all(0.0);  // two sums wait half as long
            for (std::size_t c = 0; c < tile; ++c) {
                double* here = entries + c * tile + p * width;
                Vec entry = load(here);
                if (scaled) entry = entry * scale;
                // On the diagonal the same for (i, c) and (c, i), to the bit.
                entry = entry + (diagonal ? (g * right_gain[c]) * coefficient : g * right_gain[c]);
                store(here, entry);
                if (c % 2 == 0) even = even + entry * right_row[c];
                else odd = odd + entry * right_row[c];
                if (!diagonal) sum[c] = sum[c] + entry * phi;
            }
            store(next + p * width, even + odd);
        }
    }

    // P <- scale P + coefficient gain gain', then next = P row.
    template <bool scaled>
    INLINE void pass() {
        double *entries = P.data, *__restrict next_ = next;
        const double *__restrict gain_ = gain, *__restrict row_ = row.data;
        const Vec s = all(scale), q = all(coefficient);
        for (std::size_t j = 0; j < blocks * tile; j += width) store(next_ + j, all(0.0));
        for (std::size_t J = 0; J < blocks; ++J) {
            Vec right_gain[tile], right_row[tile], sum[tile];
            for (std::size_t c = 0; c < tile; ++c) {
                right_gain[c] = all(coefficient * gain_[J * tile + c]);
                right_row[c] = all(row_[J * tile + c]);
                sum[c] = all(0.0);
            }
            for (std::size_t I = 0; I < J; ++I, entries += tile * tile)
                one_tile<scaled, false>(entries, gain_ + I * tile, row_ + I * tile, next_ + I * tile,
                                        s, q, right_gain, right_row, sum);
            for (std::size_t c = 0; c < tile; ++c) right_gain[c] = all(gain_[J * tile + c]);
            one_tile<scaled, true>(entries, gain_ + J * tile, row_ + J * tile, next_ + J * tile, s, q,
                                   right_gain, right_row, sum);
            entries += tile * tile;
            for (std::size_t p = 0; p < parts; ++p) {
                double* here = next_ + J * tile + p * width;
                store(here, load(here) + sums_of(sum + p * width));
            }
        }
    }

    void measure(const double* phi, double rhs, double lambda, double* __restrict theta) {
        double* __restrict row_ = row.data;
        const std::size_t whole = n / width * width;
        Vec innovations = all(0.0), alphas = all(0.0);
        for (std::size_t j = 0; j < whole; j += width) {
            store(row_ + j, load(phi + j));
            innovations = innovations + load(phi + j) * load(theta + j);
        }
        double innovation = rhs + sum_of(innovations);
        for (std::size_t j = whole; j < n; ++j) innovation += (row_[j] = phi[j]) * theta[j];
        if (scale == 1.0) pass<false>();
        else pass<true>();
        for (std::size_t j = 0; j < blocks * tile; j += width)
            alphas = alphas + load(row_ + j) * load(next + j);
        const double alpha = lambda + sum_of(alphas), step = innovation / alpha;
        for (std::size_t j = 0; j < whole; j += width)
            store(theta + j, load(theta + j) - load(next + j) * all(step));
        for (std::size_t j = whole; j < n; ++j) theta[j] -= next[j] * step;
        double* before = gain;
        gain = next, next = before;
        scale = 1.0 / lambda;
        coefficient = -1.0 / (alpha * lambda);
    }
};

}  // namespace

// `steps` scalar measurements  phi theta + target = 0  of unit weight, the whole record `repeat`
// times; P (n x n) and theta go in and come out.
extern "C" void symmetric_covariance(std::size_t n, std::size_t steps, std::size_t repeat,
                                     const double* phi, const double* target, double lambda,
                                     double* P, double* theta) {
    Recursion r(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            if (i <= j || i / tile == j / tile) r.P.data[place(i, j)] = P[i * n + j];
    for (std::size_t pass = 0; pass < repeat; ++pass)
        for (std::size_t k = 0; k < steps; ++k) r.measure(phi + k * n, target[k], lambda, theta);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i; j < n; ++j)
            P[i * n + j] = P[j * n + i] =
                r.scale * r.P.data[place(i, j)] + r.coefficient * r.gain[i] * r.gain[j];
}
