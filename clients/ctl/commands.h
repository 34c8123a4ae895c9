// The commands of hapticctl, one file for each group. A command is a function that adds its
// subcommands to the command line; their callbacks do the work and throw Failure. `options` lives
// as long as the program. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>

#include "clients/ctl/connection.h"

namespace hapticd::ctl {

/// Of the ids of tools (scene.proto).
inline constexpr std::uint32_t kMaxToolId = 31;

/// --discover: the daemons of the local network, by mDNS. To be added after the options it obeys.
void add_discover_option(CLI::App& app, const GlobalOptions& options);
/// status: what the daemon does, once.
void add_status_command(CLI::App& app, const GlobalOptions& options);
/// watch: the same, live, until q.
void add_watch_command(CLI::App& app, const GlobalOptions& options);
/// scene list, scene load, scene check.
void add_scene_commands(CLI::App& app, const GlobalOptions& options);
/// get, set: live parameters.
void add_parameter_commands(CLI::App& app, const GlobalOptions& options);
/// engage, disengage, clear, recentre, clutch.
void add_force_commands(CLI::App& app, const GlobalOptions& options);
/// stop: by the Stop road, or a session.
void add_stop_command(CLI::App& app, const GlobalOptions& options);
/// gesture list, gesture play, gesture end.
void add_gesture_commands(CLI::App& app, const GlobalOptions& options);
/// record start, record stop, record dump, record list.
void add_record_commands(CLI::App& app, const GlobalOptions& options);
/// run step, run live, run stop: time under the virtual clock.
void add_run_commands(CLI::App& app, const GlobalOptions& options);
/// pose: poses of the scripted device from a table.
void add_pose_command(CLI::App& app, const GlobalOptions& options);
/// experiment: that of hapticd-lab.
void add_experiment_command(CLI::App& app, const GlobalOptions& options);
/// doctor: the machine examined by hapticd; no daemon needs to run.
void add_doctor_command(CLI::App& app, const GlobalOptions& options);
/// device list, device info, device monitor, device calibrate, device check.
void add_device_commands(CLI::App& app, const GlobalOptions& options);
/// replay, export: a recording played again, or as a table, by hapticd; no daemon needs to run.
void add_replay_commands(CLI::App& app, const GlobalOptions& options);
/// keygen: the keys of a daemon.
void add_keygen_command(CLI::App& app, const GlobalOptions& options);

/// All commands, in the order of the help.
inline constexpr std::array kCommands{
    add_status_command, add_watch_command,   add_scene_commands,   add_parameter_commands,
    add_force_commands, add_stop_command,    add_gesture_commands, add_record_commands,
    add_run_commands,   add_pose_command,    add_doctor_command,   add_experiment_command,
    add_keygen_command, add_replay_commands, add_device_commands,
};

}  // namespace hapticd::ctl
