// The interacting multiple model filter (Blom and Bar-Shalom 1988), in square roots.
#pragma once

#include <limits>

#include "estimation/kalman.hpp"

namespace rcac {

// One filter for each mode of a plant that jumps between them as a Markov chain. x and P are mean
// and covariance of the mixture. Probabilities are kept as logarithms: a mode that was ruled out by
// any number of nats may come back.
class InteractingFilters final : public KalmanFilter {
public:
    using Filters = std::vector<std::unique_ptr<KalmanFilter>>;

    // transitions: row i holds the probabilities of going from mode i to each.
    InteractingFilters(Filters filters, std::shared_ptr<EstimationModel> sizes,
                       const std::vector<double>& transitions,
                       const std::vector<double>& probabilities)
        : KalmanFilter(sizes, std::vector<double>(sizes->n), std::vector<double>(sizes->n * sizes->n),
                       {}, {}),
          filters_(std::move(filters)),
          modes_(filters_.size()),
          log_transitions_(logarithms(transitions)),
          log_mu_(logarithms(probabilities)),
          terms_(modes_),
          mixed_x_(modes_ * n_),
          mixed_S_(modes_ * n_ * n_),
          root_(std::max(n_, p_) * modes_ * (std::max(n_, p_) + 1)) {
        combine();
        corrected_ = x_;
    }

    void predict(const double* u) override {
        keep(before_prediction_);
        try {
            mix();
            for (std::size_t j = 0; j < modes_; ++j)
                in_mode(j, [&] { filters_[j]->predict(u); });
            combine();
        } catch (...) {
            put_back(before_prediction_);
            throw;
        }
        ++k_;
    }
    std::size_t modes() const override { return modes_; }
    void probabilities(double* mu) const override {
        for (std::size_t j = 0; j < modes_; ++j) mu[j] = std::exp(log_mu_[j]);
    }
    double log_likelihood() const override { return log_likelihood_; }

    void visit(Archive& archive) override {
        KalmanFilter::visit(archive);
        archive(log_mu_);
        for (const auto& filter : filters_) filter->visit(archive);
    }

protected:
    void remember() override { keep(before_correction_); }
    void go_back() override { put_back(before_correction_); }

private:
    struct Mixture {
        std::vector<Belief> beliefs;
        Belief whole;
        std::vector<double> log_mu;
    };

    void correct_there(const double* y, const double* u) override {
        remember();
        try {
            for (std::size_t j = 0; j < modes_; ++j)
                in_mode(j, [&] { filters_[j]->correct(y, u); });
            judge();
            for (std::size_t j = 0; j < modes_; ++j)
                terms_[j] = log_mu_[j] + filters_[j]->log_likelihood();
            log_likelihood_ = log_sum(terms_);
            require_range(&log_likelihood_, 1);
            for (std::size_t j = 0; j < modes_; ++j) log_mu_[j] = terms_[j] - log_likelihood_;
            combine();
        } catch (...) {
            go_back();
            throw;
        }
        corrected_ = x_;
    }

    // The innovation of the mixture and its covariance, of which the mean of e' S^-1 e is that of
    // a Gaussian, and the distribution is not.
    void judge() {
        const std::size_t q = there_.size(), columns = modes_ * (q + 1);
        innovation_.assign(p_, std::nan(""));
        for (const std::size_t i : there_) innovation_[i] = 0.0;
        for (std::size_t j = 0; j < modes_; ++j)
            for (const std::size_t i : there_)
                innovation_[i] += std::exp(log_mu_[j]) * filters_[j]->innovation()[i];
        for (std::size_t j = 0; j < modes_; ++j) {
            const double share = std::exp(0.5 * log_mu_[j]);
            const std::vector<double>& L = filters_[j]->innovation_root();
            for (std::size_t i = 0; i < q; ++i) {
                double* row = root_.data() + i * columns + j * (q + 1);
                for (std::size_t m = 0; m < q; ++m) row[m] = share * L[i * q + m];
                row[q] = share * (filters_[j]->innovation()[there_[i]] - innovation_[there_[i]]);
            }
        }
        triangularise(root_.data(), q, columns);
        for (std::size_t i = 0; i < q; ++i) whitened_[i] = innovation_[there_[i]];
        if (!solve_lower(root_.data(), q, columns, whitened_.data()))
            throw EstimationError{"singular", "the covariance of the innovation is singular"};
        weigh(root_.data(), columns);
    }

    // What each mode believes at k becomes what it believes where it is the mode of k + 1.
    void mix() {
        const std::vector<Belief>& before = before_prediction_.beliefs;
        for (std::size_t j = 0; j < modes_; ++j) {
            for (std::size_t i = 0; i < modes_; ++i)
                terms_[i] = log_transitions_[i * modes_ + j] + before_prediction_.log_mu[i];
            log_mu_[j] = log_sum(terms_);
            double* x = mixed_x_.data() + j * n_;
            std::fill_n(x, n_, 0.0);
            for (std::size_t i = 0; i < modes_; ++i) {  // a mode that nothing leads to goes on alone
                terms_[i] = log_mu_[j] > -infinity ? std::exp(terms_[i] - log_mu_[j])
                                                   : static_cast<double>(i == j);
                for (std::size_t m = 0; m < n_; ++m) x[m] += terms_[i] * before[i].x[m];
            }
            spread(
                x, [&](std::size_t i) { return std::pair(before[i].x.data(), before[i].S.data()); },
                mixed_S_.data() + j * n_ * n_);
        }
        for (std::size_t j = 0; j < modes_; ++j)
            filters_[j]->believe(mixed_x_.data() + j * n_, mixed_S_.data() + j * n_ * n_);
    }

    // Mean and covariance over the modes.
    void combine() {
        for (std::size_t j = 0; j < modes_; ++j) terms_[j] = std::exp(log_mu_[j]);
        std::fill(next_.begin(), next_.end(), 0.0);
        for (std::size_t j = 0; j < modes_; ++j)
            for (std::size_t m = 0; m < n_; ++m)
                next_[m] += terms_[j] * filters_[j]->x()[m];
        spread(
            next_.data(),
            [&](std::size_t j) {
                return std::pair(filters_[j]->x().data(), filters_[j]->root().data());
            },
            S_.data());
        require_range(next_.data(), n_);
        require_range(S_.data(), n_ * n_);
        x_ = next_;
    }

    // S with S S' = sum w_i (S_i S_i' + (x_i - x)(x_i - x)'); the weights are the terms.
    template <class BeliefOf>
    void spread(const double* x, BeliefOf belief_of, double* S) {
        const std::size_t columns = modes_ * (n_ + 1);
        for (std::size_t i = 0; i < modes_; ++i) {
            const double share = std::sqrt(terms_[i]);
            const auto [x_i, S_i] = belief_of(i);
            for (std::size_t m = 0; m < n_; ++m) {
                double* row = root_.data() + m * columns + i * (n_ + 1);
                for (std::size_t l = 0; l < n_; ++l) row[l] = share * S_i[m * n_ + l];
                row[n_] = share * (x_i[m] - x[m]);
            }
        }
        triangularise(root_.data(), n_, columns);
        for (std::size_t m = 0; m < n_; ++m) std::copy_n(root_.data() + m * columns, n_, S + m * n_);
    }

    template <class Step>
    static void in_mode(std::size_t j, Step step) {
        try {
            step();
        } catch (const EstimationError& error) {
            throw EstimationError{error.kind,
                                  "in mode " + std::to_string(j) + ", " + error.what()};
        }
    }
    void keep(Mixture& into) const {
        into.beliefs.resize(modes_);
        for (std::size_t j = 0; j < modes_; ++j) filters_[j]->keep(into.beliefs[j]);
        KalmanFilter::keep(into.whole);
        into.log_mu = log_mu_;
    }
    void put_back(const Mixture& from) {
        for (std::size_t j = 0; j < modes_; ++j) filters_[j]->put_back(from.beliefs[j]);
        KalmanFilter::put_back(from.whole);
        log_mu_ = from.log_mu;
    }

    static constexpr double infinity = std::numeric_limits<double>::infinity();
    static std::vector<double> logarithms(std::vector<double> values) {
        for (double& value : values) value = std::log(value);
        return values;
    }
    double log_sum(const std::vector<double>& terms) const {
        double largest = -infinity, sum = 0.0;
        for (std::size_t i = 0; i < modes_; ++i) largest = std::max(largest, terms[i]);
        if (!(largest > -infinity)) return -infinity;
        for (std::size_t i = 0; i < modes_; ++i) sum += std::exp(terms[i] - largest);
        return largest + std::log(sum);
    }

    Filters filters_;
    std::size_t modes_;
    std::vector<double> log_transitions_, log_mu_, terms_, mixed_x_, mixed_S_, root_;
    Mixture before_correction_, before_prediction_;
    double log_likelihood_ = 0.0;
};

}  // namespace rcac
