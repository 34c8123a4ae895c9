// The format of our recordings: its number, and the topic of each message of recording.proto.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace hapticd {

/// Layout of our recordings, as in RecordHeader.format_version; readers refuse a larger one. 3
/// shows of each tick what clients were shown.
inline constexpr std::uint32_t kRecordFormat = 3;
/// Oldest layout that is read. 1 had not all that a replay needs.
inline constexpr std::uint32_t kOldestRecordFormat = 2;

/// What a message of a recording is.
enum class RecordKind : std::uint8_t { kHeader, kScene, kParameters, kTick, kEvent, kSnapshot };

/// Topic of each message of recording.proto.
inline constexpr std::string_view kHeaderTopic = "/hapticd/header";
inline constexpr std::string_view kSceneTopic = "/hapticd/scene";
inline constexpr std::string_view kParameterTopic = "/hapticd/parameters";
inline constexpr std::string_view kTickTopic = "/hapticd/tick";
inline constexpr std::string_view kEventTopic = "/hapticd/event";
inline constexpr std::string_view kSnapshotTopic = "/hapticd/snapshot";

/// In the order of RecordKind.
inline constexpr std::array kRecordTopics{kHeaderTopic, kSceneTopic, kParameterTopic,
                                          kTickTopic,   kEventTopic, kSnapshotTopic};

}  // namespace hapticd
