// The standard problem (2.1)-(2.3), with matrices that may change while it runs.
#pragma once

#include <memory>

#include "plants/plant.hpp"

namespace rcac {

// All nine matrices as one, row-major: [x(k+1); y; z] = rows of [A B D_1; C D_0 D_2; E_1 E_2 E_0]
// times [x; u; w].
struct PlantMatrices {
    std::size_t n;
    std::vector<double> rows;
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
        resize();
        std::size_t longest = 0;
        for (const Segment& s : segments_) longest = std::max(longest, s.delay);
        if (longest > 0) {
            past_u_ = std::make_unique<History>(sizes.l_u, longest);
            delayed_.resize(sizes.l_u);
        }
    }

    std::unique_ptr<Plant> copy(std::vector<double> x_0) const override {
        return std::make_unique<LinearPlant>(sizes_, segments_, std::move(x_0));
    }

    bool begin(std::int64_t k, const double* w) override {
        k_ = k;
        while (number_ + 1 < segments_.size() && segments_[number_ + 1].start <= k) enter(number_ + 1);
        if (segments_[number_].ramp) interpolate(k);
        if (past_u_) {
            if (!begun_) past_u_->advance();
            delay_input();
        }
        begun_ = true;
        copy_few(w, sizes_.l_w, input_.data() + m_.n + sizes_.l_u);
        return true;
    }

    void receive(const double* u) override {
        if (past_u_) {
            for (std::size_t i = 0; i < sizes_.l_u; ++i) past_u_->now(i) = u[i];
            delay_input();
            u = delayed_.data();
        }
        copy_few(u, sizes_.l_u, input_.data() + m_.n);
    }

    bool y(double* y) override {
        output(m_.n, sizes_.l_y, y);
        return true;
    }
    bool z(double* z) override {
        output(m_.n + sizes_.l_y, sizes_.l_z, z);
        return true;
    }
    bool advance() override {
        output(0, m_.n, next_.data());
        std::swap(x_, next_);
        copy_few(x_.data(), m_.n, input_.data());
        ++k_;
        begun_ = false;
        return true;
    }

    // Whether it is nothing but one set of matrices; then these are they.
    bool is_constant() const { return segments_.size() == 1 && !past_u_; }
    const PlantMatrices& matrices() const { return m_; }
    // For whoever makes its steps elsewhere (lanes/state.hpp).
    void has_stepped(std::int64_t steps, const std::vector<double>& x) {
        k_ += steps;
        x_ = x;
        copy_few(x_.data(), m_.n, input_.data());
    }

    void visit(Archive& archive) override {
        archive(k_, 0, Archive::longest);
        auto number = static_cast<std::int64_t>(number_);
        archive(number, 0, static_cast<std::int64_t>(segments_.size()) - 1);
        if (archive.reading()) {
            number_ = static_cast<std::size_t>(number);
            m_ = segments_.at(number_).matrices;
            x_.resize(m_.n);
            resize();
        }
        archive(x_);
        std::copy(x_.begin(), x_.end(), input_.begin());
        if (past_u_) past_u_->visit(archive);
    }
    void visit_within_step(Archive& archive) override {
        visit(archive);
        std::int64_t begun = begun_;
        archive(begun, 0, 1);
        begun_ = begun != 0;
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
        resize();
    }

    void resize() {
        next_.resize(m_.n);
        input_.assign(m_.n + sizes_.l_u + sizes_.l_w, 0.0);
        std::copy(x_.begin(), x_.end(), input_.begin());
    }

    void interpolate(std::int64_t k) {
        const Segment &from = segments_[number_], &to = segments_[number_ + 1];
        const double part =
            static_cast<double>(k - from.start) / static_cast<double>(to.start - from.start);
        for (std::size_t i = 0; i < m_.rows.size(); ++i)
            m_.rows[i] = (1.0 - part) * from.matrices.rows[i] + part * to.matrices.rows[i];
    }

    // Where u(k) is not known yet, it does not act on y or z, and its place holds a zero.
    void delay_input() {
        for (std::size_t i = 0; i < sizes_.l_u; ++i)
            delayed_[i] = (*past_u_)(i, segments_[number_].delay);
    }

    void output(std::size_t first, std::size_t count, double* out) const {
        const std::size_t width = input_.size();
        const double* row = m_.rows.data() + first * width;
        for (std::size_t i = 0; i < count; ++i, row += width) {
            double sum = 0.0;
            for (std::size_t j = 0; j < width; ++j) sum += row[j] * input_[j];
            out[i] = sum;
        }
    }

    std::vector<Segment> segments_;
    PlantMatrices m_;
    std::size_t number_ = 0;
    bool begun_ = false;  // the step, which a caller outside may begin more than once
    std::unique_ptr<History> past_u_;
    std::vector<double> delayed_, input_;  // input_ is [x; u; w]
};

}  // namespace rcac
