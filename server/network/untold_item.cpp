// See untold_item.h.
#include "server/network/untold_item.h"

#include <string>

#include "proto/wire/request_result.h"
#include "proto/wire/whole_characters.h"

namespace hapticd {
namespace {

/// Longest name, and hash, in a notice, bytes.
constexpr std::size_t kNameBytes = 64;

v1::SceneInfo notice_for(const v1::SceneInfo& info) {
  v1::SceneInfo notice;
  notice.set_scene_id(info.scene_id());
  notice.mutable_scene()->set_name(wire::whole_characters(info.scene().name(), kNameBytes));
  notice.set_hash(info.hash().substr(0, kNameBytes));
  notice.set_rate_hz(info.rate_hz());
  notice.set_clock(info.clock());
  notice.set_server_version(wire::whole_characters(info.server_version(), kNameBytes));
  return notice;
}

v1::Result notice_for(const v1::Result& result) {
  v1::Result notice = wire::result_of(result.code(), result.path(), result.message());
  notice.set_item_id(result.item_id());
  if (result.code() != v1::RESULT_CODE_OK) return notice;
  notice.set_code(v1::RESULT_CODE_FAILED);
  notice.set_message(
      "The answer has " + std::to_string(result.ByteSizeLong()) +
      " bytes, and there is no room for it now. Ask for less, or wait until what was "
      "asked before has come.");
  return notice;
}

}  // namespace

std::optional<v1::Item> notice_for(const v1::Item& item) {
  v1::Item notice;
  if (item.has_scene_info()) {
    *notice.mutable_scene_info() = notice_for(item.scene_info());
  } else if (item.has_result()) {
    *notice.mutable_result() = notice_for(item.result());
  } else {
    return std::nullopt;
  }
  return notice;
}

}  // namespace hapticd
