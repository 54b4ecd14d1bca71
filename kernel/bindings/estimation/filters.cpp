// Models and Kalman filters as Python sees them.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings/bindings.hpp"
#include "bindings/estimation/python_model.hpp"
#include "bindings/owned.hpp"
#include "estimation/extended.hpp"
#include "estimation/interacting.hpp"
#include "estimation/noises.hpp"
#include "estimation/observability.hpp"
#include "estimation/tape.hpp"
#include "estimation/unscented.hpp"

namespace rcac {
namespace {

struct OwnedFilter {
    std::unique_ptr<KalmanFilter> filter;
    InUse use{"filter"};
    std::vector<double> u, y;
    void visit(Archive& archive) { filter->visit(archive); }
};

using Model = std::shared_ptr<EstimationModel>;
using Instructions = nb::ndarray<const std::int32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Results = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

void require_sizes(std::size_t n, std::size_t l_u, std::size_t l_y) {
    require_width(n, 1, "n");
    require_width(l_u, 0, "l_u");
    require_width(l_y, 1, "l_y");
    length_of({2 * n + 1 + l_y, 3 * n + 1 + l_y}, "the covariance");
}

Model linear_model(std::size_t n, std::size_t l_u, std::size_t l_y, const Array& A, const Array& B,
                   const Array& C, const Array& D) {
    require_sizes(n, l_u, l_y);
    return std::make_shared<LinearEstimationModel>(n, l_u, l_y, copied(A, n * n, "A"),
                                                   copied(B, n * l_u, "B"), copied(C, l_y * n, "C"),
                                                   copied(D, l_y * l_u, "D"));
}

Model function_model(std::size_t n, std::size_t l_u, std::size_t l_y, nb::object f, nb::object h,
                     nb::object F, nb::object H, nb::object residual, const Array& scale) {
    require_sizes(n, l_u, l_y);
    return std::make_shared<PythonModel>(n, l_u, l_y, std::move(f), std::move(h), std::move(F),
                                         std::move(H), std::move(residual),
                                         copied(scale, n, "scale"));
}

Tape tape_of(nb::handle given, std::size_t n, std::size_t l_u, std::size_t size) {
    const auto parts = read<nb::tuple>(given, "a tape", "a tuple");
    refuse_unless(parts.size() == 3, "a tape has three parts");
    const auto constants = read<Array>(parts[0], "the constants", "a float64 array");
    const auto steps = read<Instructions>(parts[1], "the steps", "an int32 matrix");
    const auto results = read<Results>(parts[2], "the results", "an int32 array");
    refuse_unless(steps.shape(1) == 3, "a step has three numbers");
    refuse_unless(results.size() == size, "the tape has the wrong number of results");
    const std::size_t before = constants.size() + n + l_u + 1;
    length_of({before + steps.shape(0)}, "the tape");
    std::vector<Tape::Step> list;
    for (std::size_t i = 0; i < steps.shape(0); ++i) {
        const std::int32_t* step = steps.data() + 3 * i;
        const auto last = static_cast<std::int64_t>(before + i) - 1;
        require_range<std::int64_t>(step[0], 0, static_cast<std::int64_t>(Operation::count) - 1,
                                    "an operation");
        require_range<std::int64_t>(step[1], 0, last, "an operand");
        require_range<std::int64_t>(step[2], 0, last, "an operand");
        list.push_back({static_cast<Operation>(step[0]), static_cast<std::uint32_t>(step[1]),
                        static_cast<std::uint32_t>(step[2])});
    }
    std::vector<std::uint32_t> places;
    for (std::size_t i = 0; i < results.size(); ++i) {
        require_range<std::int64_t>(results.data()[i], 0,
                                    static_cast<std::int64_t>(before + list.size()) - 1, "a result");
        places.push_back(static_cast<std::uint32_t>(results.data()[i]));
    }
    return Tape(copied(constants, constants.size(), "the constants"), n, l_u, std::move(list),
                std::move(places));
}

Model tape_model(std::size_t n, std::size_t l_u, std::size_t l_y, nb::handle f, nb::handle h,
                 nb::handle f_F, nb::handle h_H) {
    require_sizes(n, l_u, l_y);
    return std::make_shared<TapeModel>(n, l_u, l_y, tape_of(f, n, l_u, n), tape_of(h, n, l_u, l_y),
                                       tape_of(f_F, n, l_u, n + n * n),
                                       tape_of(h_H, n, l_u, l_y + l_y * n));
}

Model model_of(nb::handle given) {
    Model shared;
    if (!nb::try_cast(given, shared) || !shared) throw nb::type_error("this is not a model");
    return shared;
}

std::unique_ptr<OwnedFilter> owned(std::unique_ptr<KalmanFilter> filter) {
    auto made = std::make_unique<OwnedFilter>();
    made->u.resize(filter->model().l_u);
    made->y.resize(filter->model().l_y);
    made->filter = std::move(filter);
    return made;
}

std::unique_ptr<KalmanFilter> single_filter(const std::string& kind, const Model& model,
                                            const Array& x_0, const Array& S_0, const Array& Q_root,
                                            const Array& R_root, double alpha, double beta) {
    const std::size_t n = model->n, p = model->l_y;
    std::vector<double> x = copied(x_0, n, "x_0"), S = copied(S_0, n * n, "S_0"),
                        Q = copied(Q_root, n * n, "Q_root"), R = copied(R_root, p * p, "R_root");
    if (kind == "extended") return std::make_unique<ExtendedKalmanFilter>(model, x, S, Q, R);
    if (kind == "joseph") return std::make_unique<JosephKalmanFilter>(model, x, S, Q, R);
    refuse_unless(kind == "unscented", "no filter named " + kind.substr(0, 200));
    refuse_unless(alpha > 0.0 && alpha < 1e300, "alpha is not positive");
    refuse_unless(beta >= 0.0 && beta < 1e300, "beta is negative");
    return std::make_unique<UnscentedKalmanFilter>(alpha, beta, model, x, S, Q, R);
}

std::unique_ptr<OwnedFilter> filter(const std::string& kind, nb::handle model, const Array& x_0,
                                    const Array& S_0, const Array& Q_root, const Array& R_root,
                                    double alpha, double beta) {
    return owned(single_filter(kind, model_of(model), x_0, S_0, Q_root, R_root, alpha, beta));
}

// Each filter as the arguments of `filter`.
std::unique_ptr<OwnedFilter> interacting_filters(const nb::list& filters, const Array& transitions,
                                                 const Array& probabilities) {
    InteractingFilters::Filters made;
    Model sizes;
    const std::size_t modes = filters.size();
    refuse_unless(modes > 0, "there is no filter");
    for (nb::handle each : filters) {
        const auto given = read<nb::tuple>(each, "a filter", "a tuple");
        refuse_unless(given.size() == 8, "a filter has eight arguments");
        const auto kind = read<std::string>(given[0], "kind", "text");
        refuse_unless(kind != "joseph", "a filter in Joseph's form has no square root");
        const Model model = model_of(given[1]);
        if (!sizes) sizes = model;
        refuse_unless(model->n == sizes->n && model->l_u == sizes->l_u && model->l_y == sizes->l_y,
                      "the models have other sizes");
        const auto array = [&](std::size_t i) { return read<Array>(given[i], "a part", "an array"); };
        made.push_back(single_filter(kind, model, array(2), array(3), array(4), array(5),
                                     read<double>(given[6], "alpha", "a number"),
                                     read<double>(given[7], "beta", "a number")));
    }
    const std::size_t widest = std::max(sizes->n, sizes->l_y);
    length_of({widest, modes, widest + 1}, "the covariances");
    const auto shares = [](const Array& given, std::size_t size, const char* name) {
        std::vector<double> values = copied(given, size, name);
        for (const double value : values) require_range(value, 0.0, 1.0, name);
        return values;
    };
    return owned(std::make_unique<InteractingFilters>(
        std::move(made), sizes, shares(transitions, modes * modes, "transitions"),
        shares(probabilities, modes, "probabilities")));
}

struct NoisesGiven {
    std::vector<double> x, S, Q, R;
    NoisesGiven(const Model& model, const Array& x_0, const Array& S_0, const Array& Q_root,
                const Array& R_root)
        : x(copied(x_0, model->n, "x_0")),
          S(copied(S_0, model->n * model->n, "S_0")),
          Q(copied(Q_root, model->n * model->n, "Q_root")),
          R(copied(R_root, model->l_y * model->l_y, "R_root")) {}
};

std::unique_ptr<OwnedFilter> adaptive_filter(nb::handle model, const Array& x_0, const Array& S_0,
                                             const Array& Q_root, const Array& R_root,
                                             std::size_t window, std::int64_t iterations,
                                             bool learns_Q, bool learns_R, bool diagonal) {
    const Model shared = model_of(model);
    NoisesGiven given(shared, x_0, S_0, Q_root, R_root);
    length_of({window, shared->n + 1, shared->n + shared->l_u + shared->l_y}, "the window");
    refuse_unless(window > 1, "the window is shorter than 2");
    require_range<std::int64_t>(iterations, 1, 10000, "iterations");
    return owned(std::make_unique<AdaptiveKalmanFilter>(
        window, iterations, LearnedNoises{learns_Q, learns_R, diagonal}, shared, std::move(given.x),
        std::move(given.S), std::move(given.Q), std::move(given.R)));
}

// Roots of Q and R after one iteration over a record, and the likelihood before it.
nb::tuple learn_noises(nb::handle model, const Array& x_0, const Array& S_0, const Array& Q_root,
                       const Array& R_root, const Array& u, const Array& y, bool learns_Q,
                       bool learns_R, bool diagonal) {
    const Model shared = model_of(model);
    NoisesGiven given(shared, x_0, S_0, Q_root, R_root);
    const std::size_t n = shared->n, p = shared->l_y, steps = y.size() / p;
    require(y.size(), steps * p, "y");
    require(u.size(), steps * shared->l_u, "u");
    refuse_unless(steps > 0, "there is no step");
    length_of({steps, n + 2, n}, "the filtered covariances");
    NoiseLearning learning(shared, LearnedNoises{learns_Q, learns_R, diagonal});
    const Belief start{0, given.x, given.S, std::vector<double>(p), 0.0, 0.0};
    const double likelihood =
        learning.iterate(start, y.data(), u.data(), steps, given.Q, given.R);
    return nb::make_tuple(to_numpy(std::move(given.Q), {n, n}), to_numpy(std::move(given.R), {p, p}),
                          likelihood);
}

// Whether the arguments could be read; then what is asked for was done.
bool move(OwnedFilter& self, nb::handle y, nb::handle u, bool corrects, bool predicts) {
    if (!quick_read(u, self.u) || (corrects && !quick_read(y, self.y, true))) return false;
    for (const double value : self.y)
        if (corrects && std::isinf(value)) return false;
    const Hold hold(self.use);
    if (corrects && predicts)
        self.filter->correct_and_predict(self.y.data(), self.u.data());
    else if (corrects)
        self.filter->correct(self.y.data(), self.u.data());
    else
        self.filter->predict(self.u.data());
    return true;
}

// All steps of a record: y and u hold one row for each step, NaN where an entry of y is missing.
// Writes x(k|k), its standard deviations, P(k|k) where asked for, innovations, NIS and, of several
// modes, their probabilities.
void run(OwnedFilter& self, const Array& u, const Array& y, Output& x, Output& deviation, Output& P,
         Output& innovation, Output& nis, Output& log_likelihood, Output& probabilities) {
    KalmanFilter& filter = *self.filter;
    const std::size_t n = filter.model().n, l_u = filter.model().l_u, p = filter.model().l_y,
                      steps = nis.size();
    require(u.size(), steps * l_u, "u");
    require(y.size(), steps * p, "y");
    require(x.size(), steps * n, "x");
    require(deviation.size(), steps * n, "deviation");
    refuse_unless(P.size() == 0 || P.size() == steps * n * n, "P has the wrong size");
    require(innovation.size(), steps * p, "innovation");
    require(log_likelihood.size(), steps, "log_likelihood");
    require(probabilities.size(), steps * filter.modes(), "probabilities");
    const Hold hold(self.use);
    for (std::size_t k = 0; k < steps; ++k) {
        const double* input = u.data() + k * l_u;
        filter.correct(y.data() + k * p, input);
        if (filter.measured()) {
            std::copy_n(filter.innovation().data(), p, innovation.data() + k * p);
            nis.data()[k] = filter.squared_innovation();
            log_likelihood.data()[k] = filter.log_likelihood();
        }
        std::copy_n(filter.x().data(), n, x.data() + k * n);
        for (std::size_t i = 0; i < n; ++i)
            deviation.data()[k * n + i] = std::sqrt(std::max(filter.variance(i), 0.0));
        if (P.size()) filter.covariance(P.data() + k * n * n);
        if (filter.modes()) filter.probabilities(probabilities.data() + k * filter.modes());
        filter.predict(input);
        if (k % 1024 == 1023 && PyErr_CheckSignals() != 0) throw nb::python_error();
    }
}

nb::object sensitivity_of(nb::handle model, const Array& x, const Array& u, const Array& measured,
                          const Array& scale, const Array& weight, double growth) {
    const Model shared = model_of(model);
    const std::size_t n = shared->n, steps = measured.size() / shared->l_y;
    require(measured.size(), steps * shared->l_y, "measured");
    require(x.size(), steps * n, "x");
    require(u.size(), steps * shared->l_u, "u");
    require(scale.size(), n, "scale");
    require(weight.size(), shared->l_y, "weight");
    return nb::cast(to_numpy(sensitivity(*shared, steps, x.data(), u.data(), measured.data(),
                                         scale.data(), weight.data(), growth),
                             {n, n}));
}

}  // namespace

void bind_filters(nb::module_& m) {
    // In Python its arguments are the kind and the words.
    const nb::object raised = nb::exception<EstimationError>(m, "EstimationError");
    nb::register_exception_translator(
        [](const std::exception_ptr& thrown, void* type) {
            try {
                std::rethrow_exception(thrown);
            } catch (const EstimationError& error) {
                const nb::tuple arguments = nb::make_tuple(error.kind, error.what());
                PyErr_SetObject(static_cast<PyObject*>(type), arguments.ptr());
            }
        },
        raised.ptr());
    nb::class_<EstimationModel>(m, "EstimationModel")
        .def("set_angles",
             [](EstimationModel& self, const std::vector<bool>& is_angle) {
                 refuse_unless(is_angle.size() == self.l_y, "one bool for each measurement");
                 self.is_angle = is_angle;
             });
    nb::class_<OwnedFilter>(m, "Filter")
        .def("move", &move, nb::arg("y").none(), nb::arg("u").none(), nb::arg("corrects"),
             nb::arg("predicts"))
        .def("run", &run, nb::arg("u"), nb::arg("y"), nb::arg("x"), nb::arg("deviation"),
             nb::arg("P"), nb::arg("innovation"), nb::arg("nis"),
             nb::arg("log_likelihood"), nb::arg("probabilities"))
        .def("set_noises",
             [](OwnedFilter& self, const Array& Q_root, const Array& R_root) {
                 const Hold hold(self.use);
                 const std::size_t n = self.filter->model().n, p = self.filter->model().l_y;
                 const auto read = [](const Array& root, std::size_t size, const char* name) {
                     return root.size() == 0 ? std::vector<double>() : copied(root, size, name);
                 };
                 self.filter->set_noises(read(Q_root, n * n, "Q_root"),
                                         read(R_root, p * p, "R_root"));
             },
             nb::arg("Q_root"), nb::arg("R_root"))
        .def("save",
             [](OwnedFilter& self) {
                 const Hold hold(self.use);
                 Archive archive;
                 self.visit(archive);
                 return to_numpy(archive.values().data(), archive.values().size());
             })
        .def("restore",
             [](OwnedFilter& self, const Array& state) {
                 const Hold hold(self.use);
                 restore(self, copied(state, state.size(), "state"));
             })
        .def_prop_ro("k", [](const OwnedFilter& self) { return self.filter->k(); })
        .def_prop_ro("nis", [](const OwnedFilter& self) { return self.filter->squared_innovation(); })
        .def_prop_ro("innovation",
                     [](const OwnedFilter& self) {
                         return to_numpy(self.filter->innovation().data(),
                                         self.filter->innovation().size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("x",
                     [](const OwnedFilter& self) {
                         return to_numpy(self.filter->x().data(), self.filter->x().size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("corrected",
                     [](const OwnedFilter& self) {
                         return to_numpy(self.filter->corrected().data(),
                                         self.filter->corrected().size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("probabilities",
                     [](const OwnedFilter& self) {
                         std::vector<double> mu(self.filter->modes());
                         self.filter->probabilities(mu.data());
                         return to_numpy(mu.data(), mu.size());
                     },
                     nb::rv_policy::automatic)
        .def_prop_ro("noises",
                     [](const OwnedFilter& self) {
                         const std::vector<double>&Q = self.filter->Q_root(),
                                           &R = self.filter->R_root();
                         return nb::make_tuple(to_numpy(Q.data(), Q.size()),
                                               to_numpy(R.data(), R.size()));
                     })
        .def_prop_ro("P",
                     [](const OwnedFilter& self) {
                         const std::size_t n = self.filter->x().size();
                         std::vector<double> P(n * n);
                         self.filter->covariance(P.data());
                         return to_numpy(std::move(P), {n, n});
                     },
                     nb::rv_policy::automatic);
    m.def("linear_estimation_model", &linear_model, nb::arg("n"), nb::arg("l_u"), nb::arg("l_y"),
          nb::arg("A"), nb::arg("B"), nb::arg("C"), nb::arg("D"));
    m.def("function_estimation_model", &function_model, nb::arg("n"), nb::arg("l_u"),
          nb::arg("l_y"), nb::arg("f"), nb::arg("h"), nb::arg("F").none(), nb::arg("H").none(),
          nb::arg("residual").none(), nb::arg("scale"));
    m.def("tape_estimation_model", &tape_model, nb::arg("n"), nb::arg("l_u"), nb::arg("l_y"),
          nb::arg("f"), nb::arg("h"), nb::arg("f_F"), nb::arg("h_H"));
    m.def("filter", &filter, nb::arg("kind"), nb::arg("model"), nb::arg("x_0"), nb::arg("S_0"),
          nb::arg("Q_root"), nb::arg("R_root"), nb::arg("alpha"), nb::arg("beta"));
    m.def("interacting_filters", &interacting_filters, nb::arg("filters"), nb::arg("transitions"),
          nb::arg("probabilities"));
    m.def("adaptive_filter", &adaptive_filter, nb::arg("model"), nb::arg("x_0"), nb::arg("S_0"),
          nb::arg("Q_root"), nb::arg("R_root"), nb::arg("window"), nb::arg("iterations"),
          nb::arg("learns_Q"), nb::arg("learns_R"), nb::arg("diagonal"));
    m.def("learn_noises", &learn_noises, nb::arg("model"), nb::arg("x_0"), nb::arg("S_0"),
          nb::arg("Q_root"), nb::arg("R_root"), nb::arg("u"), nb::arg("y"), nb::arg("learns_Q"),
          nb::arg("learns_R"), nb::arg("diagonal"));
    m.def("sensitivity", &sensitivity_of, nb::arg("model"), nb::arg("x"), nb::arg("u"),
          nb::arg("measured"), nb::arg("scale"), nb::arg("weight"), nb::arg("growth"));
}

}  // namespace rcac
