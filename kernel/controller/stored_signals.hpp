// The stored signals filtered anew, as if the target model had been there from the beginning.
#pragma once

#include "controller/plan.hpp"

namespace rcac {

// How many steps beyond its own delays a controller remembers its signals, for a target model that
// is set while it runs: the rows that can be replayed, and the time that D_f has to settle.
constexpr std::size_t remembered_steps = 200;
// Over so many steps two target models are compared.
constexpr std::size_t compared_steps = 64;

// F(k) = G_f(q) s(k) of several signals, newest first in one piece of memory each. The sums run in
// the order of TargetFilter, so that an FIR model gives its numbers bit for bit.
class FilteredPast {
public:
    FilteredPast(const TargetModel& model, std::vector<std::size_t> sources, std::size_t length)
        : l_z_(model.l_z), l_u_(model.l_u), length_(length), sources_(std::move(sources)),
          values_(sources_.size() * l_z_ * l_u_ * length_) {}

    // The newest `ages` steps; a model with D_f begins with zeros before the oldest of all.
    void run(const TargetModel& model, const History& signals, std::size_t ages) {
        bool recursive = false;
        for (std::size_t i = l_z_ * l_z_; i < model.denominator.size(); ++i)
            recursive = recursive || model.denominator[i] != 0.0;
        ages_ = recursive ? length_ : std::min(ages, length_);
        for (std::size_t s = 0; s < sources_.size(); ++s)
            for (std::size_t age = ages_; age-- > 0;)
                for (std::size_t row = 0; row < l_z_; ++row)
                    for (std::size_t column = 0; column < l_u_; ++column)
                        place(s, row, column)[age] =
                            entry(model, signals, s, row, column, age, recursive);
    }

    double operator()(std::size_t s, std::size_t row, std::size_t column, std::size_t age) const {
        return age < ages_ ? values_[((s * l_z_ + row) * l_u_ + column) * length_ + age] : 0.0;
    }
    std::size_t number_of(std::size_t source) const {
        return static_cast<std::size_t>(std::find(sources_.begin(), sources_.end(), source) -
                                        sources_.begin());
    }
    std::size_t length() const { return length_; }
    std::size_t l_z() const { return l_z_; }
    std::size_t l_u() const { return l_u_; }

    // sum |this - other|^2 / sum |this|^2 over the newest steps; 0 where nothing was filtered yet.
    double distance(const FilteredPast& other) const {
        double gap = 0.0, size = 0.0;
        const std::size_t ages = std::min({ages_, other.ages_, compared_steps});
        for (std::size_t entry = 0; entry < values_.size(); entry += length_)
            for (std::size_t age = 0; age < ages; ++age) {
                const double now = values_[entry + age], before = other.values_[entry + age];
                gap += (now - before) * (now - before);
                size += now * now;
            }
        return size > 0.0 ? gap / size : (gap > 0.0 ? 1.0 : 0.0);
    }

private:
    double* place(std::size_t s, std::size_t row, std::size_t column) {
        return values_.data() + ((s * l_z_ + row) * l_u_ + column) * length_;
    }

    double entry(const TargetModel& model, const History& signals, std::size_t s, std::size_t row,
                 std::size_t column, std::size_t age, bool recursive) {
        const double* in = signals.past(sources_[s]) + age;
        const std::size_t reach = std::min(model.order + 1, signals.depth() - age);
        double sum = 0.0;
        for (std::size_t i = 0; i < reach; ++i)
            sum += model.numerator[(i * l_z_ + row) * l_u_ + column] * in[i];
        if (recursive)
            for (std::size_t m = 0; m < l_z_; ++m) {
                const double* out = place(s, m, column) + age;
                for (std::size_t i = 1; i <= model.order && age + i < ages_; ++i)
                    sum -= model.denominator[(i * l_z_ + row) * l_z_ + m] * out[i];
            }
        return sum;
    }

    std::size_t l_z_, l_u_, length_, ages_ = 0;
    std::vector<std::size_t> sources_;
    std::vector<double> values_;
};

// The target model in force: one of the plan's, or one that was set while the controller ran.
class CurrentTarget {
public:
    CurrentTarget(const std::vector<TargetModel>& planned, std::vector<std::size_t> sources,
                  std::size_t length)
        : planned_(&planned), model_(planned.at(0)), before_(model_, std::move(sources), length),
          after_(before_) {}

    const TargetModel& model() const { return model_; }
    const FilteredPast& past() const { return after_; }
    const TargetModel& take_planned(std::size_t number) {
        number_ = static_cast<std::int64_t>(number);
        return model_ = planned_->at(number);
    }
    // The past is filtered with it for so many steps, or a replay's.
    void take(const TargetModel& model, const History& signals, std::size_t ages) {
        before_.run(model_, signals, compared_steps);
        after_.run(model, signals, std::max(ages, compared_steps));
        rho_ = after_.distance(before_);
        model_ = model;
        number_ = -1;
    }
    bool is_own() const { return number_ < 0; }
    double rho() const { return rho_; }

    void visit(Archive& archive, std::size_t longest_order) {
        archive(rho_);
        archive(number_, -1, static_cast<std::int64_t>(planned_->size()) - 1);
        if (number_ >= 0) {
            if (!archive.reading()) return;
            const TargetModel& planned = (*planned_)[static_cast<std::size_t>(number_)];
            if (planned.order > longest_order)
                throw std::invalid_argument("its target model does not fit into its filter");
            model_ = planned;
            return;
        }
        auto order = static_cast<std::int64_t>(model_.order);
        archive(order, 0, static_cast<std::int64_t>(longest_order));
        const std::size_t length = static_cast<std::size_t>(order) + 1;
        model_.order = length - 1;
        model_.numerator.resize(length * model_.l_z * model_.l_u);
        model_.denominator.resize(length * model_.l_z * model_.l_z);
        archive(model_.numerator);
        archive(model_.denominator);
    }

private:
    const std::vector<TargetModel>* planned_;
    TargetModel model_;
    FilteredPast before_, after_;
    double rho_ = 0.0;  // |new - old|^2 / |new|^2 of the filtered signals at the last change
    std::int64_t number_ = 0;
};

// The distinct signals that the filter is fed with.
inline std::vector<std::size_t> sources_of(const Structure& structure) {
    std::vector<std::size_t> result;
    for (const Tap& tap : structure.channels)
        if (std::find(result.begin(), result.end(), tap.source) == result.end())
            result.push_back(tap.source);
    return result;
}

// The past of the filter's outputs is what another model makes of the same signals.
inline void refill_outputs(TargetFilter& filter, const FilteredPast& past,
                           const Structure& structure) {
    for (std::size_t c = 0; c < structure.channels.size(); ++c) {
        const Tap& tap = structure.channels[c];
        const std::size_t s = past.number_of(tap.source);
        for (std::size_t row = 0; row < past.l_z(); ++row)
            for (std::size_t column = 0; column < past.l_u(); ++column)
                for (std::size_t age = 0; age < filter.outputs().depth(); ++age)
                    filter.outputs().at(filter.index(c, row, column), age) =
                        past(s, row, column, age + tap.delay);
    }
}

// The past of the filter's inputs, for a filter that is new.
inline void refill_inputs(TargetFilter& filter, const History& signals, const Structure& structure) {
    for (std::size_t c = 0; c < structure.channels.size(); ++c) {
        const Tap& tap = structure.channels[c];
        for (std::size_t age = 0; age < filter.inputs().depth(); ++age)
            filter.inputs().at(c, age) = signals(tap.source, tap.delay + age);
    }
}

// Phi_f of so many steps ago, and u_f taken from `target`, in the order of the ordinary step.
inline void data_of_age(const FilteredPast& past, const Structure& structure, std::size_t age,
                        double* Phi_f, double* target) {
    for (std::size_t row = 0; row < past.l_z(); ++row) {
        for (const Tap& tap : structure.filtered) {
            const Tap& channel = structure.channels[tap.source];
            const std::size_t s = past.number_of(channel.source);
            for (std::size_t i = 0; i < past.l_u(); ++i)
                *Phi_f++ = past(s, row, i, age + channel.delay + tap.delay);
        }
        for (std::size_t i = 0; i < past.l_u(); ++i)
            target[row] -= past(past.number_of(i), row, i, age);
    }
}

}  // namespace rcac
