// Fixed capacities of the realtime path. Everything the loop touches is sized by these at compile
// time; an overflow is counted and handled conservatively, never allocated for.
#pragma once

#include <cstddef>

namespace hapticd {

/// Tools that play in one scene, at most.
inline constexpr std::size_t kMaxTools = 5;

/// Unknowns of a rigid tool: [linear; angular].
inline constexpr int kToolDof = 6;
/// Strings that may deflect under one tool in one tick; those touched beyond them are treated as
/// rigid for that tick and counted.
inline constexpr int kMaxDeflectingStrings = 64;
/// Strings whose unknowns share one dense matrix; where more deflect, those of each are eliminated
/// by themselves.
inline constexpr int kMaxDenseStrings = 8;
/// Soft parts of a tool that may be displaced in one tick; a sixth one touched is treated as rigid
/// for that tick and counted.
inline constexpr int kMaxSoftParts = 5;
/// Unknowns of the quadratic program: tool, two lateral deflections per deflecting string, and the
/// displacement of each soft part.
inline constexpr int kMaxQpUnknowns = kToolDof + 2 * kMaxDeflectingStrings + 3 * kMaxSoftParts;
/// Unknowns of a dense matrix.
inline constexpr int kMaxDenseUnknowns = kToolDof + 2 * kMaxDenseStrings + 3 * kMaxSoftParts;
/// Of those that remain where the strings' are eliminated.
inline constexpr int kMaxCoreUnknowns = kToolDof + 3 * kMaxSoftParts;
/// Rows of the quadratic program.
inline constexpr int kMaxQpRows = 256;
/// Modes per string, at most.
inline constexpr int kMaxModes = 64;
/// Events of strings one tick can report; more are counted and dropped.
inline constexpr int kMaxStringEvents = 64;
/// Candidate pairs one query keeps (the nearest ones); rows are chosen or merged from these.
inline constexpr int kMaxCandidates = 2048;
/// Room for more while it looks for them.
inline constexpr int kSpareCandidates = 1024;

}  // namespace hapticd
