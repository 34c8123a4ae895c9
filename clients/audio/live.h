// haptic-audio at work: a session with the daemon, a sound card by JACK, and what is said about
// both. Either may go away and come back. One thread beside JACK's. Not RT.
#pragma once

#include <cstdint>

#include "clients/audio/options.h"
#include "proto/wire/clock_estimate.h"

namespace hapticd::audio {

/// When an event of the server's t_ns is heard, on this clock: D later. While the clocks'
/// relation is not known, D after it came, at now_ns; likewise under the virtual clock, whose t_ns
/// has no relation to ours.
[[nodiscard]] std::int64_t due_ns(std::uint64_t t_ns, const wire::ClockEstimate& clock,
                                  bool real_clock, std::int64_t now_ns, std::int64_t delay_ns);

/// Plays until SIGINT or SIGTERM; the exit code.
int play_live(const Options& options);

/// Writes where sound can go to stdout, for people or as ports_json(); throws NoJackServer.
void list_ports(bool json);

/// The folder of recorded tones: as given, else the shipped ones, as installed beside the program;
/// empty with --synth, or when there are none.
[[nodiscard]] std::string tones_folder(const Options& options);

/// Factor of --gain-db.
[[nodiscard]] double gain_of(const Options& options);

}  // namespace hapticd::audio
