// hapticd-model: sphere-trees from triangle meshes, meshes from models, reports and pictures of
// both. Exit codes: 0 good, 1 the input is bad, 2 the command line makes no sense.
#include <array>

#include "server/command_line/program.h"
#include "server/model/commands.h"

namespace {

/// All commands, in the order of the help.
constexpr auto kCommands = std::to_array<hapticd::AddCommand>({
    hapticd::add_build_command,
    hapticd::add_make_command,
    hapticd::add_list_command,
    hapticd::add_inspect_command,
    hapticd::add_check_command,
    hapticd::add_explain_command,
});

constexpr hapticd::Program kProgram{
    "hapticd-model",
    "Models and scenes for hapticd: sphere-trees from triangle meshes, and what scenes make of "
    "them.",
    kCommands,
};

}  // namespace

int main(int argc, char** argv) { return hapticd::run_program(kProgram, argc, argv); }
