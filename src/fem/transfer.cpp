#include "fem/transfer.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "fem/session.hpp"

namespace sanatrix::fem {
namespace {

std::vector<int> gathered(const std::vector<int>& mine) {
  const std::vector<double> all = gather({mine.begin(), mine.end()});  // exact below 2^53
  return {all.begin(), all.end()};
}

std::vector<bool> owned(std::size_t count, const auto& owns) {
  std::vector<bool> own(count);
  for (std::size_t i = 0; i < count; ++i) {
    own[i] = owns(static_cast<int>(i));
  }
  return own;
}

/// Numbers of this process's edges in the whole mesh: rank 0 looks them up by their end vertices.
std::vector<int> edge_numbers(const MeshShare& share, const EdgeTable& edges,
                              const TetMesh& whole) {
  std::vector<double> ends;
  for (const auto& edge : edges.edges) {
    for (const int v : edge) {
      ends.push_back(share.vertex()[static_cast<std::size_t>(v)]);
    }
  }
  const std::vector<double> asked = gather(ends);
  const EdgeTable all =
      make_edges(rank() == 0 ? std::span(whole.cells) : std::span<const std::array<int, 4>>{});
  std::vector<double> answers;
  for (std::size_t i = 0; i < asked.size(); i += 2) {
    answers.push_back(all.find(static_cast<int>(asked[i]), static_cast<int>(asked[i + 1])));
  }
  const std::vector<double> mine = scatter(answers, edges.edges.size());
  return {mine.begin(), mine.end()};
}

}  // namespace

Transfer::Transfer(std::vector<int> number, std::vector<bool> own)
    : number_(std::move(number)), own_(std::move(own)), wanted_(gathered(number_)) {
  std::vector<int> mine;
  for (std::size_t i = 0; i < number_.size(); ++i) {
    if (own_[i]) {
      mine.push_back(number_[i]);
    }
  }
  sent_ = gathered(mine);
}

std::vector<double> Transfer::to_leader(std::span<const double> local, int width) const {
  const auto w = static_cast<std::size_t>(width);
  ensure(local.size() == w * number_.size(), "{} values for {} items", local.size(),
         number_.size());
  std::vector<double> mine;
  for (std::size_t i = 0; i < number_.size(); ++i) {
    if (own_[i]) {
      const auto values = local.subspan(w * i, w);
      mine.insert(mine.end(), values.begin(), values.end());
    }
  }
  const std::vector<double> all = gather(mine);
  std::vector<double> whole(all.size());
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    std::ranges::copy(std::span(all).subspan(w * i, w),
                      whole.begin() + static_cast<std::ptrdiff_t>(w) * sent_[i]);
  }
  return whole;
}

std::vector<double> Transfer::from_leader(std::span<const double> whole, int width) const {
  const auto w = static_cast<std::size_t>(width);
  std::vector<double> all;
  all.reserve(w * wanted_.size());
  for (const int number : wanted_) {
    const auto values = whole.subspan(w * static_cast<std::size_t>(number), w);
    all.insert(all.end(), values.begin(), values.end());
  }
  return scatter(all, w * number_.size());
}

Transfer vertex_transfer(const MeshShare& share) {
  return {share.vertex(),
          owned(share.vertex().size(), [&](int v) { return share.owns_vertex(v); })};
}

Transfer cell_transfer(const MeshShare& share) {
  return {share.cell(), owned(share.cell().size(), [&](int c) { return share.owns_cell(c); })};
}

Transfer node_transfer(const MeshShare& share, const EdgeTable& edges, const TetMesh& whole) {
  const Layout layout = share.layout(edges);
  std::vector<int> number = share.vertex();
  for (const int edge : edge_numbers(share, edges, whole)) {
    number.push_back(share.whole_vertices() + edge);
  }
  std::vector<bool> own = owned(number.size(), [&](int n) { return layout.owns(n); });
  return {std::move(number), std::move(own)};
}

}  // namespace sanatrix::fem
