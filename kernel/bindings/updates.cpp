// The updates by themselves, on recorded data: for tests of their arithmetic and for benchmarks.
#include "bindings/bindings.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/replay.hpp"

namespace rcac {
namespace {

using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Cube = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <class Array>
void require_shape(const Array& array, const std::vector<std::size_t>& shape, const char* name) {
    for (std::size_t i = 0; i < shape.size(); ++i)
        refuse_unless(array.shape(i) == shape[i], std::string(name) + ": extent " +
                                                      std::to_string(array.shape(i)) + " where " +
                                                      std::to_string(shape[i]) + " belongs");
}

nb::tuple replay_updates(const std::string& update, const Cube& Phi_f, const Matrix& target,
                         const Matrix& R_z, const Matrix& R_u, double forgetting, const Matrix& P_0,
                         const Vector& theta_0, std::size_t repeat, const std::string& set_name) {
    const std::size_t steps = Phi_f.shape(0), l_z = Phi_f.shape(1), l_theta = Phi_f.shape(2);
    require_width(l_theta, 1, "l_theta");
    require_width(l_z, 1, "l_z");
    require_forgetting(forgetting, "forgetting");
    require_shape(target, {steps, l_z}, "target");
    require_shape(R_z, {l_z, l_z}, "R_z");
    require_shape(R_u, {l_z, l_z}, "R_u");
    require_shape(P_0, {l_theta, l_theta}, "P_0");
    require_shape(theta_0, {l_theta}, "theta_0");
    std::vector<double> theta(theta_0.data(), theta_0.data() + l_theta), P(l_theta * l_theta);
    const auto run = make_update(update, P_0.data(), l_theta, instruction_set(set_name.c_str()));
    bool finite = false;
    {
        nb::gil_scoped_release release;
        finite = replay(*run,
                        {l_z, l_theta, Phi_f.data(), target.data(), R_z.data(), R_u.data(),
                         forgetting},
                        steps, repeat, theta.data());
        run->covariance(P.data());
    }
    return nb::make_tuple(to_numpy(std::move(theta), {l_theta}),
                          to_numpy(std::move(P), {l_theta, l_theta}), run->guard().count,
                          run->guard().first_step, finite);
}

nb::tuple replay_ud_lanes(const Cube& Phi_f, const Matrix& target, double forgetting,
                          const Cube& P_0, const Matrix& theta_0, std::size_t repeat,
                          const std::string& set_name) {
    const std::size_t steps = Phi_f.shape(0), l_theta = Phi_f.shape(1);
    require_width(l_theta, 1, "l_theta");
    require_forgetting(forgetting, "forgetting");
    require_shape(Phi_f, {steps, l_theta, lanes}, "Phi_f");
    require_shape(target, {steps, lanes}, "target");
    require_shape(P_0, {lanes, l_theta, l_theta}, "P_0");
    require_shape(theta_0, {l_theta, lanes}, "theta_0");
    const InstructionSet& chosen = instruction_set(set_name.c_str());
    std::vector<double> theta(theta_0.data(), theta_0.data() + l_theta * lanes);
    std::vector<double> P(lanes * l_theta * l_theta);
    std::vector<std::int64_t> lost(lanes, 0);
    UdLanes runs(l_theta, chosen);
    std::vector<UdUpdate> single;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
        single.emplace_back(P_0.data() + lane * l_theta * l_theta, l_theta, chosen);
        runs.load(lane, single.back());
    }
    bool finite = false;
    {
        nb::gil_scoped_release release;
        finite = replay_lanes(runs, Phi_f.data(), target.data(), forgetting, steps, repeat,
                              theta.data(), lost.data());
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            runs.store(lane, single[lane]);
            single[lane].covariance(P.data() + lane * l_theta * l_theta);
        }
    }
    return nb::make_tuple(to_numpy(std::move(theta), {l_theta, lanes}),
                          to_numpy(std::move(P), {lanes, l_theta, l_theta}), lost, finite);
}

}  // namespace

void bind_updates(nb::module_& m) {
    m.attr("lanes") = lanes;
    m.def("instruction_sets", [] {
        std::vector<std::string> names;
        const InstructionSets all = instruction_sets();
        for (std::size_t i = 0; i < all.count; ++i) names.push_back(all.first[i]->name);
        return names;
    });
    m.def("replay_updates", &replay_updates, nb::arg("update"), nb::arg("Phi_f"), nb::arg("target"),
          nb::kw_only(), nb::arg("R_z"), nb::arg("R_u"), nb::arg("forgetting") = 1.0,
          nb::arg("P_0"), nb::arg("theta_0"), nb::arg("repeat") = 1, nb::arg("instruction_set") = "");
    m.def("replay_ud_lanes", &replay_ud_lanes, nb::arg("Phi_f"), nb::arg("target"), nb::kw_only(),
          nb::arg("forgetting") = 1.0, nb::arg("P_0"), nb::arg("theta_0"), nb::arg("repeat") = 1,
          nb::arg("instruction_set") = "");
}

}  // namespace rcac
