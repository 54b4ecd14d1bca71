// The standard problem (2.1)-(2.3), with matrices that may change while it runs.
#pragma once

#include <array>
#include <memory>

#include "plant.hpp"

namespace rcac {

// Row-major matrices in the order A, B, D_1, C, D_0, D_2, E_1, E_2, E_0.
struct PlantMatrices {
    std::size_t n;
    std::array<std::vector<double>, 9> values;
};

// From `start` on the plant has these matrices. The state is carried over by `state_map`
// (n x n of the segment before; empty: as it is). With `ramp` the matrices move linearly towards
// those of the next segment, which they reach at its start. u acts `delay` steps late.
struct Segment {
    std::int64_t start;
    PlantMatrices matrices;
    bool ramp;
    std::vector<double> state_map;
    std::size_t delay;
};

class LinearPlant final : public Plant {
public:
    LinearPlant(const Sizes& sizes, std::vector<Segment> segments, std::vector<double> x_0)
        : Plant(sizes, std::move(x_0)), segments_(std::move(segments)), m_(segments_.at(0).matrices) {
        std::size_t longest = 0;
        for (const Segment& s : segments_) longest = std::max(longest, s.delay);
        if (longest > 0) {
            past_u_ = std::make_unique<History>(sizes.l_u, longest);
            delayed_.resize(sizes.l_u);
        }
    }

    bool begin(std::int64_t k) override {
        k_ = k;
        while (number_ + 1 < segments_.size() && segments_[number_ + 1].start <= k) enter(number_ + 1);
        if (segments_[number_].ramp) interpolate(k);
        if (past_u_) {
            past_u_->advance();
            delay_input();
        }
        return true;
    }

    void receive(const double* u) override {
        u_ = u;
        if (!past_u_) return;
        for (std::size_t i = 0; i < sizes_.l_u; ++i) past_u_->now(i) = u[i];
        delay_input();
    }

    bool y(const double* w, double* y) override {
        output(3, sizes_.l_y, w, y);
        return true;
    }
    bool z(const double* w, double* z) override {
        output(6, sizes_.l_z, w, z);
        return true;
    }
    bool advance(const double* w) override {
        next_.resize(m_.n);
        output(0, m_.n, w, next_.data());
        std::swap(x_, next_);
        ++k_;
        return true;
    }

    void visit(Archive& archive) override {
        archive(k_);
        auto number = static_cast<std::int64_t>(number_);
        archive(number);
        if (archive.reading()) {
            number_ = static_cast<std::size_t>(number);
            m_ = segments_.at(number_).matrices;
            x_.resize(m_.n);
        }
        archive(x_);
        if (past_u_) past_u_->visit(archive);
    }

private:
    void enter(std::size_t number) {
        const Segment& segment = segments_[number];
        const std::size_t n = segment.matrices.n;
        if (!segment.state_map.empty()) {
            next_.assign(n, 0.0);
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j < x_.size(); ++j)
                    next_[i] += segment.state_map[i * x_.size() + j] * x_[j];
            std::swap(x_, next_);
        }
        number_ = number;
        m_ = segment.matrices;
    }

    void interpolate(std::int64_t k) {
        const Segment &from = segments_[number_], &to = segments_[number_ + 1];
        const double part =
            static_cast<double>(k - from.start) / static_cast<double>(to.start - from.start);
        for (std::size_t i = 0; i < m_.values.size(); ++i)
            for (std::size_t j = 0; j < m_.values[i].size(); ++j)
                m_.values[i][j] = (1.0 - part) * from.matrices.values[i][j] +
                                  part * to.matrices.values[i][j];
    }

    // Where u(k) is not known yet, it does not act on y or z, and its place holds a zero.
    void delay_input() {
        for (std::size_t i = 0; i < sizes_.l_u; ++i)
            delayed_[i] = (*past_u_)(i, segments_[number_].delay);
    }

    // Rows of [S T V] [x; u; w], for the three matrices from `first` on.
    void output(std::size_t first, std::size_t rows, const double* w, double* out) const {
        const double* u = past_u_ ? delayed_.data() : u_;
        const double *S = m_.values[first].data(), *T = m_.values[first + 1].data(),
                     *V = m_.values[first + 2].data();
        for (std::size_t i = 0; i < rows; ++i) {
            double sum = 0.0;
            for (std::size_t j = 0; j < m_.n; ++j) sum += S[i * m_.n + j] * x_[j];
            if (u)
                for (std::size_t j = 0; j < sizes_.l_u; ++j) sum += T[i * sizes_.l_u + j] * u[j];
            for (std::size_t j = 0; j < sizes_.l_w; ++j) sum += V[i * sizes_.l_w + j] * w[j];
            out[i] = sum;
        }
    }

    std::vector<Segment> segments_;
    PlantMatrices m_;
    std::size_t number_ = 0;
    std::unique_ptr<History> past_u_;
    std::vector<double> delayed_;
};

}  // namespace rcac
