// A model that is two or four functions of the user.
#pragma once

#include <algorithm>
#include <cmath>

#include "bindings/quick_read.hpp"
#include "estimation/model.hpp"

namespace rcac {

// The functions take (k, x, u) and return arrays. A Jacobian that is None is taken by central
// differences; `scale` says how large a state typically is.
class PythonModel final : public EstimationModel {
public:
    PythonModel(std::size_t n, std::size_t l_u, std::size_t l_y, nb::object f, nb::object h,
                nb::object F, nb::object H, nb::object residual, std::vector<double> scale)
        : EstimationModel(n, l_u, l_y),
          f_(std::move(f)),
          h_(std::move(h)),
          F_(std::move(F)),
          H_(std::move(H)),
          residual_(std::move(residual)),
          scale_(std::move(scale)),
          moved_(n),
          above_(std::max(n, l_y)),
          below_(std::max(n, l_y)) {}

    void dynamics(std::int64_t k, const double* x, const double* u, double* next) override {
        call(f_, k, x, u, next, n, "f(k, x, u)");
    }
    void output(std::int64_t k, const double* x, const double* u, double* y) override {
        call(h_, k, x, u, y, l_y, "h(k, x, u)");
    }
    void linear_dynamics(std::int64_t k, const double* x, const double* u, double* next,
                         double* F) override {
        dynamics(k, x, u, next);
        if (F_.is_none())
            differences(f_, k, x, u, n, F, "f(k, x, u)");
        else
            call(F_, k, x, u, F, n * n, "the Jacobian F of f");
    }
    void linear_output(std::int64_t k, const double* x, const double* u, double* y,
                       double* H) override {
        output(k, x, u, y);
        if (H_.is_none())
            differences(h_, k, x, u, l_y, H, "h(k, x, u)");
        else
            call(H_, k, x, u, H, l_y * n, "the Jacobian H of h");
    }

    void difference(const double* y, const double* expected, double* out) override {
        if (residual_.is_none()) return EstimationModel::difference(y, expected, out);
        take(residual_(to_numpy(y, l_y), to_numpy(expected, l_y)), out, l_y,
             "residual(y, expected)");
    }

private:
    void call(const nb::object& function, std::int64_t k, const double* x, const double* u,
              double* out, std::size_t size, const char* name) {
        take(function(k, to_numpy(x, n), to_numpy(u, l_u)), out, size, name);
    }
    void take(const nb::object& result, double* out, std::size_t size, const char* name) {
        values_.resize(size);
        if (!quick_read(result, values_)) read_with_care(result, name);
        std::copy(values_.begin(), values_.end(), out);
    }
    // Lists, arrays of integers, and what is wrong.
    void read_with_care(const nb::object& result, const char* name) {
        if (result.is_none())
            throw EstimationError{"model", std::string(name) + " returned None"};
        const nb::object array =
            nb::module_::import_("numpy").attr("ascontiguousarray")(result, "float64");
        Array view;
        if (!nb::try_cast(array, view, false))
            throw EstimationError{"model", std::string(name) + " returned no array of numbers"};
        if (view.size() != values_.size())
            throw EstimationError{"model", std::string(name) + " returned " +
                                               std::to_string(view.size()) + " numbers where " +
                                               std::to_string(values_.size()) + " are needed"};
        std::copy_n(view.data(), view.size(), values_.begin());
        require_finite(values_.data(), values_.size(), name);
    }
    void differences(const nb::object& function, std::int64_t k, const double* x, const double* u,
                     std::size_t rows, double* J, const char* name) {
        const double relative = std::cbrt(2.3e-16);
        std::copy_n(x, n, moved_.begin());
        for (std::size_t j = 0; j < n; ++j) {
            const double step = relative * std::max(std::fabs(x[j]), scale_[j]);
            moved_[j] = x[j] + step;
            const double high = moved_[j];
            call(function, k, moved_.data(), u, above_.data(), rows, name);
            moved_[j] = x[j] - step;
            const double width = high - moved_[j];
            call(function, k, moved_.data(), u, below_.data(), rows, name);
            moved_[j] = x[j];
            for (std::size_t i = 0; i < rows; ++i) J[i * n + j] = (above_[i] - below_[i]) / width;
        }
    }
    nb::object f_, h_, F_, H_, residual_;
    std::vector<double> scale_, moved_, above_, below_, values_;
};

}  // namespace rcac
