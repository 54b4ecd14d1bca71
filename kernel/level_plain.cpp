// For every processor: vectors of 16 bytes, which x86-64 and arm64 both have.
#define RCAC_LEVEL plain
#define RCAC_WIDTH 2
#include "lane_loop_body.hpp"
#include "symmetric_body.hpp"
#include "ud_lanes_body.hpp"
#include "ud_rank_one_body.hpp"

namespace rcac {

extern const Level level_plain;
const Level level_plain{"plain",
                        &plain::ud_rank_one,
                        &plain::ud_measure,
                        &plain::symmetric_measure,
                        &plain::lanes_rank_one,
                        &plain::lanes_measure,
                        &plain::lane_steps,
                        &plain::finite};

}  // namespace rcac
