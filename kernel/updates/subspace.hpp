// Forgetting along the excited direction alone, with a floor: what is not excited stays known.
#pragma once

#include <cmath>

#include "updates/ud.hpp"

namespace rcac {

// Before each scalar measurement the information of P is divided along its row phi only (subspace
// of information forgetting; for one row it is that of Cao and Schwartz 2000):
//   P <- P + c phi phi',  c = min((1 - lambda_d) / (lambda_d q), max(0, 1/f - 1/q)),
//   q = phi' P^{-1} phi,  f = phi' P(0)^{-1} phi,  lambda_d = max(1/2, 1 - (l_theta/l_z)(1 - lambda)).
// The second bound keeps phi' P^{-1} phi >= f for the row phi itself, so that nothing winds up where
// the data are poor, whatever their scale. It bounds no eigenvalue: over rows of changing direction
// the largest one of P may exceed that of P(0). lambda_d makes the memory
// that of exponential forgetting by lambda where all directions are excited.
class SubspaceUpdate final : public Update {
public:
    SubspaceUpdate(const double* P0, std::size_t l_theta)
        : n_(l_theta), core_(P0, l_theta), initial_(P0, l_theta), w_(l_theta), row_(l_theta) {
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t j = 0; j < i; ++j) diagonal_ = diagonal_ && initial_.u(j, i) == 0.0;
    }

    std::unique_ptr<Update> copy() const override { return std::make_unique<SubspaceUpdate>(*this); }
    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        if (!rows_.take(data)) return false;
        const double share = static_cast<double>(n_) / static_cast<double>(data.l_z),
                     lambda = std::max(0.5, 1.0 - share * (1.0 - data.lambda));
        for (std::size_t r = 0; r < data.l_z; ++r) {
            const double* phi = rows_.phi(data, r);
            if (lambda < 1.0) forget(phi, lambda);
            bool lost = false;
            const bool fine = core_.measure_row(phi, rows_.scale(), rows_.rhs(r), 1.0, theta, lost);
            if (lost) guard_.raise(step);
            if (!fine) return false;
        }
        return true;
    }

    void covariance(double* P) const override { core_.covariance(P); }
    void covariance_column(std::size_t i, double* column) const override {
        core_.covariance_column(i, column);
    }
    void covariance_times(const double* x, double* product) const override {
        core_.covariance_times(x, product);
    }
    void reset() override { core_.reset(); }
    void doubt_past(double rho) override { core_.doubt_past(rho); }
    void inflate(const double* noise, std::size_t count) override { core_.inflate(noise, count); }
    double trace() const override { return core_.trace(); }
    double growth() const override { return core_.growth(); }
    void bound(double growth) override { core_.bound(growth); }
    void visit(Archive& archive) override {
        Update::visit(archive);
        core_.visit(archive);
    }

private:
    void forget(const double* phi, double lambda) {
        const double q = information(core_, phi), f = floor_of(phi);
        if (!(f > 0.0) || !(q > 0.0)) return;  // nothing is excited, or below the range of float64
        const double c = std::min((1.0 - lambda) / (lambda * q), 1.0 / f - 1.0 / q);
        if (!(c > 0.0) || !std::isfinite(c)) return;
        const double root = std::sqrt(c);
        for (std::size_t j = 0; j < n_; ++j) row_[j] = root * phi[j];
        core_.inflate(row_.data(), 1);
    }

    double floor_of(const double* phi) {
        if (!diagonal_) return information(initial_, phi);
        double sum = 0.0;
        for (std::size_t j = 0; j < n_; ++j) sum += phi[j] * phi[j] / initial_.d(j);
        return sum;
    }

    // phi' (U D U')^{-1} phi.
    double information(const UdUpdate& factors, const double* phi) {
        std::copy_n(phi, n_, w_.data());
        double sum = 0.0;
        for (std::size_t j = n_; j-- > 0;) {
            const double w = w_[j];
            sum += w * w / factors.d(j);
            for (std::size_t i = 0; i < j; ++i) w_[i] -= factors.u(i, j) * w;
        }
        return sum;
    }

    std::size_t n_;
    UdUpdate core_, initial_;
    bool diagonal_ = true;
    std::vector<double> w_, row_;
    WhitenedRows rows_;
};

}  // namespace rcac
