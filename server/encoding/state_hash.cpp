// See state_hash.h.
#include "server/encoding/state_hash.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <sodium.h>

namespace hapticd {

void add_state(const Tick& tick, const SceneIndex& index,
               const std::function<void(v1::State&)>& complete, StateHash& chain) {
  encode_state(tick, index, {kCanonicalSections, kMaxReportedContacts}, chain.state);
  complete(chain.state);
  chain.state.clear_scene_id();
  chain.state.clear_contacts_total();
  chain.bytes.clear();
  {
    google::protobuf::io::StringOutputStream stream(&chain.bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    chain.state.SerializeToCodedStream(&coded);
  }
  crypto_generichash_blake2b_state hash;
  crypto_generichash_blake2b_init(&hash, nullptr, 0, chain.hash.size());
  crypto_generichash_blake2b_update(&hash, chain.hash.data(), chain.hash.size());
  crypto_generichash_blake2b_update(
      &hash, reinterpret_cast<const std::uint8_t*>(chain.bytes.data()), chain.bytes.size());
  crypto_generichash_blake2b_final(&hash, chain.hash.data(), chain.hash.size());
}

}  // namespace hapticd
