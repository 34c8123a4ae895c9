// See recording.h.
#include "clients/library/recording.h"

namespace hapticd::client {

<<<<<<< HEAD
Recording::Recording(const std::filesystem::path& file) : reader_(file.string()) {
  RecordedMessage message;
  while (reader_.next(message)) messages_.push_back(message);
=======
constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
/// Kinds of record.
constexpr unsigned kChannel = 0x04;
constexpr unsigned kMessage = 0x05;
constexpr unsigned kChunk = 0x06;
constexpr unsigned kDataEnd = 0x0F;
/// Largest RecordHeader.format_version that is understood.
constexpr std::uint32_t kFormat = 2;

constexpr std::array<std::pair<std::string_view, RecordKind>, 6> kTopics{
    {{"/hapticd/header", RecordKind::kHeader},
     {"/hapticd/scene", RecordKind::kScene},
     {"/hapticd/parameters", RecordKind::kParameters},
     {"/hapticd/tick", RecordKind::kTick},
     {"/hapticd/event", RecordKind::kEvent},
     {"/hapticd/snapshot", RecordKind::kSnapshot}}};

/// Takes little-endian numbers from the front; once something is missing it gives zeros.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) noexcept : rest_(bytes) {}

  std::uint64_t number(std::size_t bytes) noexcept {
    const std::string_view taken = take(bytes);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(taken[i])} << (8 * i);
    }
    return value;
  }
  std::string_view take(std::uint64_t bytes) noexcept {
    if (bytes > rest_.size()) {
      failed_ = true;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(bytes));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  std::string_view text() noexcept { return take(number(4)); }
  [[nodiscard]] std::string_view rest() const noexcept { return rest_; }
  [[nodiscard]] bool failed() const noexcept { return failed_; }

 private:
  std::string_view rest_;
  bool failed_ = false;
};

std::string_view mapped(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat about {};
  void* place = MAP_FAILED;
  if (file >= 0 && ::fstat(file, &about) == 0 && about.st_size > 0) {
    place =
        ::mmap(nullptr, static_cast<std::size_t>(about.st_size), PROT_READ, MAP_PRIVATE, file, 0);
  }
  const int error = errno;
  if (file >= 0) ::close(file);
  if (place == MAP_FAILED) {
    const std::string why =
        file >= 0 && about.st_size == 0 ? "empty" : std::generic_category().message(error);
    throw std::runtime_error(path.string() + ": " + why +
                             ". Name a recording: hapticctl record list shows them");
  }
  return {static_cast<const char*>(place), static_cast<std::size_t>(about.st_size)};
}

}  // namespace

Recording::Recording(const std::filesystem::path& file) : bytes_(mapped(file)) {
  if (bytes_.starts_with(kMagic)) index(bytes_.substr(kMagic.size()));
  const bool good =
      !messages_.empty() && messages_[0].kind == RecordKind::kHeader &&
      header_.ParseFromArray(messages_[0].data.data(), static_cast<int>(messages_[0].data.size()));
  const std::uint32_t format = header_.format_version();
  if (good && format <= kFormat) return;
  ::munmap(const_cast<char*>(bytes_.data()), bytes_.size());
  throw std::runtime_error(
      file.string() + (good ? ": recorded in format " + std::to_string(format) + " by hapticd " +
                                  header_.server_version() + ". Use the version that recorded it"
                            : ": not a recording of hapticd. Name a file that hapticd recorded"));
}

Recording::~Recording() { ::munmap(const_cast<char*>(bytes_.data()), bytes_.size()); }

void Recording::index(std::string_view records) {
  Cursor cursor(records);
  while (!cursor.rest().empty()) {
    const auto opcode = static_cast<unsigned>(cursor.number(1));
    const std::string_view content = cursor.take(cursor.number(8));
    // What follows the data repeats it; what is cut off was not finished.
    ended_ = opcode == kDataEnd && !cursor.failed();
    if (cursor.failed() || ended_ || opcode == 0) return;
    take(opcode, content);
  }
}

void Recording::take(unsigned opcode, std::string_view content) {
  if (opcode == kChannel) take_channel(content);
  if (opcode == kMessage) take_message(content);
  if (opcode != kChunk) return;
  Cursor cursor(content);
  // Two times, a size and a CRC come before the compression.
  (void)cursor.take(8 + 8 + 8 + 4);
  const bool plain = cursor.text().empty();
  const std::string_view inner = cursor.take(cursor.number(8));
  unreadable_ = unreadable_ || !plain || cursor.failed();
  if (!plain || cursor.failed()) return;
  Cursor each(inner);
  while (!each.rest().empty()) {
    const auto kind = static_cast<unsigned>(each.number(1));
    const std::string_view record = each.take(each.number(8));
    unreadable_ = unreadable_ || each.failed();
    if (each.failed()) return;
    if (kind == kChannel) take_channel(record);
    if (kind == kMessage) take_message(record);
  }
}

void Recording::take_channel(std::string_view content) {
  Cursor cursor(content);
  const auto id = static_cast<std::uint16_t>(cursor.number(2));
  (void)cursor.number(2);  // schema
  const std::string_view topic = cursor.text();
  for (const auto& [name, kind] : kTopics) {
    if (!cursor.failed() && topic == name) channels_[id] = kind;
  }
}

void Recording::take_message(std::string_view content) {
  Cursor cursor(content);
  const auto channel = channels_.find(static_cast<std::uint16_t>(cursor.number(2)));
  (void)cursor.number(4);  // sequence
  const std::uint64_t time_ns = cursor.number(8);
  (void)cursor.number(8);  // time of publishing
  unreadable_ = unreadable_ || cursor.failed();
  if (cursor.failed() || channel == channels_.end()) return;
  messages_.push_back({channel->second, time_ns, cursor.rest()});
>>>>>>> front
}

}  // namespace hapticd::client
