// hapticd-oracle: numbers that need the daemon's own geometry, for hapticd-lab and for people who
// doubt. Exit codes: 0 good, 1 the input is bad or a check fails, 2 the command line makes no
// sense.
#include <array>

#include "server/command_line/program.h"
#include "tests/oracle/commands.h"

namespace {

/// All commands, in the order of the help.
constexpr auto kCommands = std::to_array<hapticd::AddCommand>({
    hapticd::add_gesture_command,
    hapticd::add_poses_command,
    hapticd::add_path_command,
    hapticd::add_baseline_command,
    hapticd::add_descent_command,
    hapticd::add_cases_command,
    hapticd::add_triangle_command,
    hapticd::add_measure_command,
    hapticd::add_strings_command,
    hapticd::add_ticks_command,
});

constexpr hapticd::Program kProgram{
    "hapticd-oracle",
    "Truths about scenes, gestures and recordings of hapticd, by exhaustive search and closed "
    "forms, as CSV or JSON.",
    kCommands,
};

}  // namespace

int main(int argc, char** argv) { return hapticd::run_program(kProgram, argc, argv); }
