// Eight runs' states and settings side by side, taken from their objects and given back.
#pragma once

#include "simd/lanes/arrays.hpp"
#include "lanes/groups.hpp"
#include "lanes/ud_lanes.hpp"

namespace rcac {

// Owns what LaneArrays points at. A lane without a run holds zeros, where the loop makes nothing
// but zeros.
class LaneState {
public:
    explicit LaneState(Loop& leader)
        : factors_(leader.controllers().front()->theta().size()) {
        Controller& c = *leader.controllers().front();
        const Structure& s = c.structure();
        const Sizes& size = leader.plant().sizes();
        const TargetModel& target = c.plan().targets.front();
        a.n = leader.plant().x().size();
        a.l_u = size.l_u, a.l_y = size.l_y, a.l_z = size.l_z, a.l_w = size.l_w, a.l_r = s.l_r;
        a.r_in_w = leader.options().r_in_w;
        a.taps = s.regressor.size(), a.channels = s.channels.size(), a.order = target.order;
        a.y_first = c.measures_first(), a.recursive = is_recursive(target);
        a.forgets = c.lambda() != 1.0;
        a.weight_moves = !c.plan().R_z.is_constant() || !c.plan().R_u.is_constant();
        a.until_control = steps_until(c.plan().k_w, c);
        a.until_update = steps_until(c.plan().k_update, c);
        // What is remembered beyond the reach of a step is in the record: see `remember`.
        a.signals = history(c.signals(), c.reach() + 1, signals_);
        a.inputs = history(c.filter().inputs(), c.filter().inputs().depth(), inputs_);
        a.outputs = history(c.filter().outputs(), c.filter().outputs().depth(), outputs_);
        regressor_ = offsets(s.regressor), channel_ = offsets(s.channels);
        for (std::size_t row = 0; row < a.l_z; ++row)
            for (const Tap& tap : s.filtered)
                for (std::size_t i = 0; i < a.l_u; ++i)
                    filtered_.push_back(
                        (c.filter().index(tap.source, row, i) * a.outputs.stretch + tap.delay) * lanes);
        a.regressor = regressor_.data(), a.channel = channel_.data(), a.filtered = filtered_.data();

        const std::size_t length = a.order + 1, l_theta = c.theta().size();
        a.plant = zeros(plant_, (a.n + a.l_y + a.l_z) * (a.n + a.l_u + a.l_w));
        a.x = zeros(x_, a.n), a.x_next = zeros(x_next_, a.n);
        a.numerator = zeros(numerator_, a.l_z * a.l_u * length);
        a.denominator = zeros(denominator_, a.l_z * a.l_z * length);
        a.theta_before = a.theta = zeros(theta_, l_theta), a.theta_next = zeros(theta_next_, l_theta);
        a.factors = factors_.factors();
        a.row = zeros(row_, l_theta), a.gain = zeros(gain_, l_theta);
        a.alpha = zeros(alpha_, a.l_z), a.target = zeros(target_, a.l_z);
        a.r = zeros(r_, 1), a.share = zeros(share_, 1);
        a.lambda = zeros(lambda_, 1), a.inverse_lambda = zeros(inverse_lambda_, 1);
        a.R_z = zeros(R_z_, 1), a.R_z_moves = zeros(R_z_moves_, 1);
        a.W = zeros(W_, 1), a.W_moves = zeros(W_moves_, 1);
        a.root = zeros(root_, a.l_z * a.l_z), a.whitened = zeros(whitened_, a.l_z * a.l_z);
        a.threshold = zeros(threshold_, 1);
        if (c.ellipsoid().is_there())
            a.reach = zeros(reach_, l_theta), a.near = zeros(near_, l_theta),
            a.normal = zeros(normal_, l_theta), a.margin = zeros(margin_, 1),
            a.slack = zeros(slack_, 1);
        for (std::size_t lane = 0; lane < lanes; ++lane) clear(lane);
    }
    LaneState(const LaneState&) = delete;

    void load(std::size_t lane, Loop& loop) {
        Controller& c = *loop.controllers().front();
        const TargetModel& target = c.plan().targets.front();
        const auto& plant = dynamic_cast<const LinearPlant&>(loop.plant());
        each(c.signals(), a.signals, lane, [](double& own, double& here) { here = own; });
        each(c.filter().inputs(), a.inputs, lane, [](double& own, double& here) { here = own; });
        each(c.filter().outputs(), a.outputs, lane, [](double& own, double& here) { here = own; });
        put(plant.matrices().rows, lane, plant_);
        put(plant.x(), lane, x_);
        put(c.theta(), lane, a.theta);
        const std::size_t length = a.order + 1, N = a.l_z * a.l_u, D = a.l_z * a.l_z;
        for (std::size_t i = 0; i < length; ++i) {
            for (std::size_t b = 0; b < N; ++b)
                numerator_[(b * length + i) * lanes + lane] = target.numerator[i * N + b];
            for (std::size_t b = 0; b < D; ++b)
                denominator_[(b * length + i) * lanes + lane] = target.denominator[i * D + b];
        }
        factors_.load(lane, dynamic_cast<UdUpdate&>(c.update()));
        if (a.reach) {
            put(c.ellipsoid().reach(), lane, reach_);
            margin_[lane] = c.ellipsoid().margin();
            look(lane, c.ellipsoid());
        }
        load_weights(lane, c);
        const double limit = std::min(loop.options().limit, 1e150);
        threshold_[lane] = limit * limit * (1.0 - 1e-9);
    }

    // After `steps` steps.
    void store(std::size_t lane, const Job& job, std::int64_t steps) {
        Loop& loop = *job.loop;
        Controller& c = *loop.controllers().front();
        remember(c, job, steps);
        each(c.signals(), a.signals, lane, [](double& own, double& here) { own = here; });
        each(c.filter().inputs(), a.inputs, lane, [](double& own, double& here) { own = here; });
        each(c.filter().outputs(), a.outputs, lane, [](double& own, double& here) { own = here; });
        for (std::size_t j = 0; j < c.theta().size(); ++j) c.theta()[j] = a.theta[j * lanes + lane];
        factors_.store(lane, dynamic_cast<UdUpdate&>(c.update()));
        c.has_stepped(steps);
        dynamic_cast<LinearPlant&>(loop.plant()).has_stepped(steps, taken(a.x, a.n, lane));
    }

    // Moves theta(k+1) of this lane into the ellipsoid, as the run's own controller does.
    void bound(std::size_t lane, Controller& c) {
        for (std::size_t j = 0; j < c.theta().size(); ++j) c.theta()[j] = a.theta[j * lanes + lane];
        if (!finite(c.theta().data(), c.theta().size())) return;  // the end of the run
        if (!c.keeps_bounds()) {
            factors_.store(lane, dynamic_cast<UdUpdate&>(c.update()));
            c.move_into_bounds();
            put(c.theta(), lane, a.theta);
        }
        look(lane, c.ellipsoid());
    }

    void clear(std::size_t lane) {
        for (AlignedVector* v : {&signals_, &inputs_, &outputs_, &plant_, &x_, &x_next_, &numerator_,
                                 &denominator_, &theta_, &theta_next_, &row_, &gain_, &share_, &R_z_,
                                 &R_z_moves_, &W_moves_, &root_, &whitened_, &target_, &reach_, &near_,
                                 &normal_, &margin_, &slack_})
            for (std::size_t i = lane; i < v->size(); i += lanes) (*v)[i] = 0.0;
        for (AlignedVector* v : {&r_, &W_, &lambda_, &inverse_lambda_, &threshold_}) (*v)[lane] = 1.0;
        factors_.clear(lane);
    }

    static std::vector<double> taken(const double* from, std::size_t count, std::size_t lane) {
        std::vector<double> result(count);
        for (std::size_t i = 0; i < count; ++i) result[i] = from[i * lanes + lane];
        return result;
    }

    LaneArrays a{};

private:
    void look(std::size_t lane, const Ellipsoid& ellipsoid) {
        put(ellipsoid.near(), lane, near_);
        for (std::size_t j = 0; j < ellipsoid.near().size(); ++j)
            normal_[j * lanes + lane] = ellipsoid.normal()[j];
        slack_[lane] = ellipsoid.slack();
    }
    static std::size_t steps_until(std::int64_t step, const Controller& c) {
        return static_cast<std::size_t>(std::max<std::int64_t>(step - c.step(), 0));
    }
    static double* zeros(AlignedVector& vector, std::size_t count) {
        vector.assign(count * lanes, 0.0);
        return vector.data();
    }
    static void put(const std::vector<double>& values, std::size_t lane, AlignedVector& to) {
        put(values, lane, to.data());
    }
    static void put(const std::vector<double>& values, std::size_t lane, double* to) {
        for (std::size_t i = 0; i < values.size(); ++i) to[i * lanes + lane] = values[i];
    }
    static LaneHistory history(const History& own, std::size_t depth, AlignedVector& values) {
        const std::size_t stretch = depth + std::max<std::size_t>(depth, 16);
        return {zeros(values, own.signals() * stretch), own.signals(), depth, stretch, stretch - depth};
    }
    std::vector<std::size_t> offsets(const std::vector<Tap>& taps) const {
        std::vector<std::size_t> result;
        for (const Tap& tap : taps)
            result.push_back((tap.source * a.signals.stretch + tap.delay) * lanes);
        return result;
    }
    template <class Move>
    static void each(History& own, const LaneHistory& here, std::size_t lane, const Move& move) {
        for (std::size_t s = 0; s < here.signals; ++s)
            for (std::size_t d = 0; d < here.depth; ++d)
                move(own.at(s, d), here.values[(s * here.stretch + here.now + d) * lanes + lane]);
    }

    // The signals of the last steps, from the record into the controller's own histories.
    void remember(Controller& c, const Job& job, std::int64_t steps) const {
        const auto known = static_cast<std::size_t>(
            std::min(steps, static_cast<std::int64_t>(c.signals().depth())));
        for (std::size_t ago = known; ago-- > 0;) {
            const auto row = static_cast<std::size_t>(job.done) - 1 - ago;
            c.signals().advance();
            c.performance().advance();
            for (std::size_t i = 0; i < a.l_u; ++i) c.signals().now(i) = job.record.u[row * a.l_u + i];
            for (std::size_t i = 0; i < a.l_y; ++i)
                c.signals().now(a.l_u + i) = job.record.y[row * a.l_y + i];
            for (std::size_t i = 0; i < a.l_r; ++i)
                c.signals().now(a.l_u + a.l_y + i) = job.w[row * a.l_w + a.r_in_w + i];
            for (std::size_t i = 0; i < a.l_z; ++i)
                c.performance().now(i) = job.record.z[row * a.l_z + i];
            c.has_applied(job.record.u + row * a.l_u);
        }
    }

    void load_weights(std::size_t lane, const Controller& c) {
        const Weight &R_z = c.plan().R_z, &R_u = c.plan().R_u;
        const std::size_t m = a.l_z;
        lambda_[lane] = c.lambda();
        inverse_lambda_[lane] = 1.0 / c.lambda();
        R_z_[lane] = R_z.base[0];
        W_[lane] = R_z.base[0] + R_u.base[0];
        R_z_moves_[lane] = R_z.z_squared;
        W_moves_[lane] = R_z.z_squared + R_u.z_squared;
        r_[lane] = c.lambda() / W_[lane];
        share_[lane] = R_z_[lane] / W_[lane];
        if (m == 1) return;
        std::vector<double> L(R_z.base), rhs(R_z.base);
        for (std::size_t i = 0; i < m * m; ++i) L[i] += R_u.base[i];
        cholesky(L.data(), m);
        for (std::size_t i = 0; i < m; ++i)  // rhs <- L^{-1} R_z
            for (std::size_t j = 0; j < m; ++j) {
                for (std::size_t k = 0; k < i; ++k) rhs[i * m + j] -= L[i * m + k] * rhs[k * m + j];
                rhs[i * m + j] /= L[i * m + i];
            }
        put(L, lane, root_);
        put(rhs, lane, whitened_);
    }

    UdLanes factors_;
    std::vector<std::size_t> regressor_, channel_, filtered_;
    AlignedVector signals_, inputs_, outputs_, plant_, x_, x_next_, numerator_, denominator_, theta_,
        theta_next_, row_, gain_, alpha_, target_, r_, share_, lambda_, inverse_lambda_, R_z_,
        R_z_moves_, W_, W_moves_, root_, whitened_, threshold_, reach_, near_, normal_, margin_, slack_;
};

}  // namespace rcac
