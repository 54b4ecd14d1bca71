#include "ud_rank_one.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

// One binary runs on every x86-64: the loader picks the widest version the processor has.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define RCAC_CLONES __attribute__((target_clones("arch=skylake-avx512", "arch=haswell", "default")))
#else
#define RCAC_CLONES
#endif

namespace rcac {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Whether f = row_j + sum U_ij row_i is no larger than the rounding errors of its terms while d_j
// is so large that an f of that size would decide the update: the data do not say whether this
// direction is excited, and with such a P(0) theta hangs on the answer.
bool lost_in_rounding(const double* row, const double* u, std::size_t j, double f, double d,
                      double alpha) {
    double size = std::fabs(row[j]);
    for (std::size_t i = 0; i < j; ++i) size += std::fabs(u[i] * row[i]);
    const double error = 16.0 * epsilon * size;
    return std::fabs(f) <= error && d * error * error > alpha;
}

template <std::size_t W>
inline __attribute__((always_inline)) void dots(double* const* column, const double* __restrict row,
                                                std::size_t rows, double* f) {
    if constexpr (W == 4) {
        const double *a = column[0], *b = column[1], *p = column[2], *q = column[3];
        double fa = 0, fb = 0, fp = 0, fq = 0;
#pragma omp simd reduction(+ : fa, fb, fp, fq)
        for (std::size_t i = 0; i < rows; ++i) {
            fa += a[i] * row[i];
            fb += b[i] * row[i];
            fp += p[i] * row[i];
            fq += q[i] * row[i];
        }
        f[0] = fa, f[1] = fb, f[2] = fp, f[3] = fq;
    } else {
        const double* a = column[0];
        double fa = 0;
#pragma omp simd reduction(+ : fa)
        for (std::size_t i = 0; i < rows; ++i) fa += a[i] * row[i];
        f[0] = fa;
    }
}

// Columns j0, ..., j0 + W - 1 together. All f of a panel depend on the old U only, so one pass over
// the rows serves W dot products; then one pass updates W columns, and the gain is read and
// written once for all of them.
template <std::size_t W>
inline __attribute__((always_inline)) double panel(double* D, double* __restrict u0,
                                                   const double* __restrict row,
                                                   double* __restrict gain, std::size_t j0,
                                                   double alpha, double noise, bool& lost) {
    double* column[W];
    column[0] = u0;
    for (std::size_t c = 1; c < W; ++c) column[c] = column[c - 1] + j0 + c - 1;
    double f[W] = {}, v[W], factor[W];
    dots<W>(column, row, j0, f);
    for (std::size_t c = 0; c < W; ++c) {
        for (std::size_t i = j0; i < j0 + c; ++i) f[c] += column[c][i] * row[i];
        f[c] += row[j0 + c];
        const double d = D[j0 + c];
        v[c] = d * f[c];
        if (d * noise > alpha && lost_in_rounding(row, column[c], j0 + c, f[c], d, alpha))
            lost = true;
        const double grown = alpha + v[c] * f[c];
        if (f[c] != 0.0) D[j0 + c] = d * (alpha / grown);
        factor[c] = -f[c] / alpha;
        alpha = grown;
    }
    if constexpr (W == 4) {
        double *a = column[0], *b = column[1], *p = column[2], *q = column[3];
        const double va = v[0], vb = v[1], vp = v[2], vq = v[3];
        const double fa = factor[0], fb = factor[1], fp = factor[2], fq = factor[3];
#pragma omp simd
        for (std::size_t i = 0; i < j0; ++i) {
            double g = gain[i];
            const double oa = a[i], ob = b[i], op = p[i], oq = q[i];
            a[i] = oa + fa * g;
            g += va * oa;
            b[i] = ob + fb * g;
            g += vb * ob;
            p[i] = op + fp * g;
            g += vp * op;
            q[i] = oq + fq * g;
            gain[i] = g + vq * oq;
        }
    } else {
        double* a = column[0];
#pragma omp simd
        for (std::size_t i = 0; i < j0; ++i) {
            const double old = a[i];
            a[i] = old + factor[0] * gain[i];
            gain[i] += v[0] * old;
        }
    }
    for (std::size_t c = 0; c < W; ++c) {  // the small triangle inside the panel
        for (std::size_t i = j0; i < j0 + c; ++i) {
            const double old = column[c][i];
            column[c][i] = old + factor[c] * gain[i];
            gain[i] += v[c] * old;
        }
        gain[j0 + c] = v[c];
    }
    return alpha;
}

}  // namespace

RCAC_CLONES
double ud_rank_one(const UdFactors& factors, const double* row, double r, double* gain,
                   bool& lost) {
    const std::size_t n = factors.n;
    double* D = factors.D;
    double largest = 0.0;
    for (std::size_t j = 0; j < n; ++j) largest = std::max(largest, std::fabs(row[j]));
    // The guard's full test costs another pass over a column; a variance below alpha / noise
    // cannot need it.
    const double noise = (1024.0 * epsilon * largest) * (1024.0 * epsilon * largest);
    double alpha = r;
    std::size_t j = 0;
    double* u = factors.U;
    for (; j + 4 <= n; j += 4) {
        alpha = panel<4>(D, u, row, gain, j, alpha, noise, lost);
        u += 4 * j + 6;
    }
    for (; j < n; ++j) {
        alpha = panel<1>(D, u, row, gain, j, alpha, noise, lost);
        u += j;
    }
    return alpha;
}

}  // namespace rcac
