// The covariance recursion on one triangle of P, as fast as this project can write it.
#pragma once

#include "memory/aligned.hpp"
#include "simd/levels.hpp"
#include "updates/update.hpp"
#include "updates/whitened_rows.hpp"

namespace rcac {

// (2.42)-(2.45) by l_z scalar measurements, P symmetric to the bit because only a triangle exists.
// The yardstick of UdUpdate's speed, and no safer than the printed text where R_theta is small:
// entries of P are still differences. The guard counts steps at which alpha is not positive.
class SymmetricCovarianceUpdate final : public Update {
public:
    SymmetricCovarianceUpdate(const double* P0, std::size_t l_theta,
                              const Level& level = rcac::level())
        : n_(l_theta),
          level_(&level),
          P_(tiles_size(n_), 0.0),
          gain_(padded_to_tiles(n_), 0.0),
          next_(padded_to_tiles(n_), 0.0),
          row_(padded_to_tiles(n_), 0.0),
          tiles_{n_, P_.data(), gain_.data(), next_.data(), 1.0, 0.0} {
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t i = 0; i <= j; ++i) {
                P_[place_in_tiles(i, j)] = P0[i * n_ + j];
                if (i / tile_size == j / tile_size) P_[place_in_tiles(j, i)] = P0[i * n_ + j];
            }
    }
    // tiles_ points into the vectors.
    SymmetricCovarianceUpdate(const SymmetricCovarianceUpdate&) = delete;
    SymmetricCovarianceUpdate& operator=(const SymmetricCovarianceUpdate&) = delete;

    bool operator()(const Data& data, std::int64_t step, double* theta) override {
        if (!rows_.take(data)) return false;
        bool finite_alpha = true, positive = true;
        for (std::size_t r = 0; r < data.l_z; ++r) {
            const double alpha =
                level_->symmetric_measure(tiles_, rows_.phi(data, r), rows_.scale(), rows_.rhs(r),
                                          data.lambda, row_.data(), theta);
            positive = positive && alpha > 0.0;
            finite_alpha = finite_alpha && std::isfinite(alpha);
        }
        if (!positive) guard_.raise(step);
        if (data.lambda != 1.0) {
            tiles_.scale = 1.0 / data.lambda;
            tiles_.coefficient /= data.lambda;
        }
        // An entry of P that overflows shows in the next P phi.
        return finite_alpha && level_->finite(theta, n_) && level_->finite(tiles_.gain, n_);
    }

    void covariance(double* P) const override {
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t i = 0; i <= j; ++i)
                P[i * n_ + j] = P[j * n_ + i] =
                    tiles_.scale * P_[place_in_tiles(i, j)] +
                    tiles_.coefficient * tiles_.gain[i] * tiles_.gain[j];
    }

private:
    std::size_t n_;
    const Level* level_;
    AlignedVector P_, gain_, next_, row_;
    SymmetricTiles tiles_;
    WhitenedRows rows_;
};

}  // namespace rcac
