// The standard problem (2.1)-(2.3), one step at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace rcac {

// Row-major matrices, named as in (2.1)-(2.3).
struct PlantMatrices {
    std::size_t n, l_u, l_w, l_y, l_z;
    std::vector<double> A, B, D_1, C, D_0, D_2, E_1, E_2, E_0;
};

class Plant {
public:
    Plant(PlantMatrices matrices, std::vector<double> x0)
        : m_(std::move(matrices)), x_(std::move(x0)), next_(m_.n) {}

    void y(const double* u, const double* w, double* y) const {
        output(m_.C, m_.D_0, m_.D_2, m_.l_y, u, w, y);
    }
    void z(const double* u, const double* w, double* z) const {
        output(m_.E_1, m_.E_2, m_.E_0, m_.l_z, u, w, z);
    }
    void advance(const double* u, const double* w) {
        output(m_.A, m_.B, m_.D_1, m_.n, u, w, next_.data());
        std::swap(x_, next_);
    }

    const std::vector<double>& x() const { return x_; }
    const PlantMatrices& matrices() const { return m_; }

private:
    void output(const std::vector<double>& S, const std::vector<double>& T,
                const std::vector<double>& V, std::size_t rows, const double* u, const double* w,
                double* out) const {
        for (std::size_t i = 0; i < rows; ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < m_.n; ++j) sum += S[i * m_.n + j] * x_[j];
            for (std::size_t j = 0; j < m_.l_u; ++j) sum += T[i * m_.l_u + j] * u[j];
            for (std::size_t j = 0; j < m_.l_w; ++j) sum += V[i * m_.l_w + j] * w[j];
            out[i] = sum;
        }
    }

    PlantMatrices m_;
    std::vector<double> x_, next_;
};

}  // namespace rcac
