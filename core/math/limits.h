// Fixed capacities of the realtime path. Everything the loop touches is sized by these at compile
// time; an overflow is counted and handled conservatively, never allocated for.
#pragma once

namespace hapticd {

/// Unknowns of a rigid tool: [linear; angular].
inline constexpr int kToolDof = 6;
/// Strings that may deflect in one tick; a ninth touched string is treated as rigid for that tick
/// and counted.
inline constexpr int kMaxDeflectingStrings = 8;
/// Unknowns of the quadratic program: tool plus two lateral deflections per deflecting string.
inline constexpr int kMaxQpUnknowns = kToolDof + 2 * kMaxDeflectingStrings;
/// Rows of the quadratic program.
inline constexpr int kMaxQpRows = 256;
/// Modes per string, at most.
inline constexpr int kMaxModes = 64;
/// Events of strings one tick can report; more are counted and dropped.
inline constexpr int kMaxStringEvents = 64;
/// Candidate pairs one query keeps (the nearest ones); rows are chosen or merged from these.
inline constexpr int kMaxCandidates = 2048;

}  // namespace hapticd
