// l_z measurements at once as l_z scalar measurements with independent noise.
#pragma once

#include "updates/update.hpp"

namespace rcac {

// With W = R_z + R_u = L L', the rows of L' Phi_f carry uncorrelated noise of variance lambda, so
// l_z scalar updates do what (2.42)-(2.44) do with one l_z x l_z inverse.
class WhitenedRows {
public:
    // False where R_z + R_u is not positive definite; a weight that is a function may do that.
    bool take(const Data& data) {
        const std::size_t m = data.l_z;
        L_.resize(m * m);
        if (m == 1) {  // the same without loops
            const double W = data.R_z[0] + data.R_u[0];
            if (!(W > 0.0)) return false;
            if (W != W_) L_[0] = std::sqrt(W_ = W);  // nearly always the W of the step before
            rhs_.resize(1);
            rhs_[0] = data.R_z[0] * data.target[0] / L_[0];
            return true;
        }
        rhs_.assign(m, 0.0);
        for (std::size_t i = 0; i < m * m; ++i) L_[i] = data.R_z[i] + data.R_u[i];
        if (!cholesky(L_.data(), m)) return false;
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t j = 0; j < m; ++j) rhs_[i] += data.R_z[i * m + j] * data.target[j];
        for (std::size_t i = 0; i < m; ++i) {  // rhs <- L^{-1} R_z (z - u_f) = L' W^{-1} R_z (..)
            for (std::size_t j = 0; j < i; ++j) rhs_[i] -= L_[i * m + j] * rhs_[j];
            rhs_[i] /= L_[i * m + i];
        }
        return true;
    }

    // Row r of L' Phi_f is scale() times this, for the measurement  row theta + rhs(r) = 0.
    const double* phi(const Data& data, std::size_t r) {
        const std::size_t m = data.l_z, n = data.l_theta;
        if (m == 1) return data.Phi_f;
        row_.resize(n);
        for (std::size_t j = 0; j < n; ++j) row_[j] = L_[r * m + r] * data.Phi_f[r * n + j];
        for (std::size_t i = r + 1; i < m; ++i)
            for (std::size_t j = 0; j < n; ++j) row_[j] += L_[i * m + r] * data.Phi_f[i * n + j];
        return row_.data();
    }
    double scale() const { return L_.size() == 1 ? L_[0] : 1.0; }
    double rhs(std::size_t r) const { return rhs_[r]; }

private:
    double W_ = 0.0;  // of a scalar measurement, whose root is L_
    std::vector<double> L_, rhs_, row_;
};

}  // namespace rcac
