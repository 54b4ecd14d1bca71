// For every processor: vectors of 16 bytes, which x86-64 and arm64 both have.
#define RCAC_INSTRUCTION_SET plain
#define RCAC_WIDTH 2
#include "simd/dispatch.hpp"
#include "simd/lanes/loop.inl.hpp"
#include "simd/lanes/ud.inl.hpp"
#include "simd/triangular.inl.hpp"
#include "simd/ud_rank_one.inl.hpp"

namespace rcac {

extern const InstructionSet set_plain;
const InstructionSet set_plain{
    "plain",
    &plain::ud_measure,
    &plain::lanes_rank_one,
    &plain::lanes_measure,
    &plain::lane_steps,
    &plain::finite,
    &plain::transposed_times,
    &plain::times,
    &plain::dot,
    &plain::growth,
};

}  // namespace rcac
