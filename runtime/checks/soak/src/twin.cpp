#include "twin.h"

#include "state/body_hashes.h"

namespace atl::soak {
namespace {

std::string words_of(std::size_t body, const BodyHash& a, const BodyHash& b) {
  std::string words = "body " + std::to_string(body) + " differs in";
  for (const auto& [name, part] : body_parts) {
    if (a.*part != b.*part) words += std::string(" ") + name;
  }
  return words;
}

}  // namespace

void Twin::compare() const {
  if (first_.state_hash() == second_.state_hash()) return;
  const std::vector<BodyHash> a = first_.body_hashes(), b = second_.body_hashes();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (!(a[i] == b[i])) throw CheckFailed("the two worlds differ: " + words_of(i, a[i], b[i]));
  }
  throw CheckFailed("the two worlds differ, but in no body");
}

}  // namespace atl::soak
