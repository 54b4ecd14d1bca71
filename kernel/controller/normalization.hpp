// The performance variable through a saturation function before it enters the retrospective cost.
#pragma once

#include <cmath>

namespace rcac {

// f(z) with f'(0) = slope and |f| < limit.
struct Normalization {
    enum Function { none, rational, root, arctan, tanh, erf };
    Function function = none;
    double limit = 1.0, slope = 1.0;

    double operator()(double z) const {
        constexpr double half_pi = 1.5707963267948966, root_of_pi = 1.7724538509055160;
        const double x = slope * z;
        switch (function) {
            case none: return z;
            case rational: return x / (1.0 + std::fabs(x) / limit);
            case root: return x / std::sqrt(1.0 + x / limit * (x / limit));
            case arctan: return limit / half_pi * std::atan(half_pi * x / limit);
            case tanh: return limit * std::tanh(x / limit);
            case erf: return limit * std::erf(0.5 * root_of_pi * x / limit);
        }
        return z;
    }
};

}  // namespace rcac
