// What a controller acts on: the interface, and plants given by functions.
#pragma once

#include <functional>
#include <memory>

#include "memory/history.hpp"

namespace rcac {

struct Sizes {
    std::size_t n, l_u, l_w, l_y, l_z;
};

// One step is: begin; receive u(k); y and z at the present state; advance. y and z are asked for
// before `receive` where the controller needs them first, and then must not depend on u(k).
class Plant {
public:
    Plant(const Sizes& sizes, std::vector<double> x_0)
        : sizes_(sizes), x_(std::move(x_0)), next_(x_.size()) {}
    virtual ~Plant() = default;

    // The same plant at step 0 with another state; null where it is made of functions.
    virtual std::unique_ptr<Plant> copy(std::vector<double> /*x_0*/) const { return nullptr; }
    // False where a function of the user has failed.
    virtual bool begin(std::int64_t k, const double* w) = 0;
    virtual void receive(const double* u) = 0;
    virtual bool y(double* y) = 0;
    virtual bool z(double* z) = 0;
    virtual bool advance() = 0;

    const Sizes& sizes() const { return sizes_; }
    const std::vector<double>& x() const { return x_; }
    virtual void visit(Archive& archive) {
        archive(k_, 0, Archive::longest);
        archive(x_);
    }
    // The same for a caller outside of a loop, who may stop within a step.
    virtual void visit_within_step(Archive& archive) { visit(archive); }

protected:
    Sizes sizes_;
    std::vector<double> x_, next_;
    std::int64_t k_ = 0;
};

// x(k+1) = f(k, x, u, w), [y; z](k) = h(k, x, w): u acts on y and z through the state only.
// Functions return 0; anything else ends the run.
struct PlantFunctions {
    using Advance = std::function<bool(std::int64_t k, const double* x, const double* u,
                                       const double* w, double* x_next)>;
    using Output =
        std::function<bool(std::int64_t k, const double* x, const double* w, double* y, double* z)>;
    Advance advance;
    Output output;
};

class FunctionPlant final : public Plant {
public:
    FunctionPlant(const Sizes& sizes, PlantFunctions functions, std::vector<double> x_0)
        : Plant(sizes, std::move(x_0)), functions_(std::move(functions)), z_(sizes.l_z), y_(sizes.l_y) {}

    bool begin(std::int64_t k, const double* w) override {
        k_ = k;
        w_ = w;
        measured_ = false;
        return true;
    }
    void receive(const double* u) override { u_ = u; }
    bool y(double* y) override {
        if (!measure()) return false;
        std::copy(y_.begin(), y_.end(), y);
        return true;
    }
    bool z(double* z) override {
        if (!measure()) return false;
        std::copy(z_.begin(), z_.end(), z);
        return true;
    }
    bool advance() override {
        if (!functions_.advance(k_, x_.data(), u_, w_, next_.data())) return false;
        std::swap(x_, next_);
        ++k_;
        return true;
    }

private:
    bool measure() {  // one call for both, at most once a step
        if (!measured_) measured_ = functions_.output(k_, x_.data(), w_, y_.data(), z_.data());
        return measured_;
    }
    PlantFunctions functions_;
    std::vector<double> z_, y_;
    const double *u_ = nullptr, *w_ = nullptr;
    bool measured_ = false;
};

}  // namespace rcac
