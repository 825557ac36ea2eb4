// A bounding-volume tree over boxes: the one search structure behind the distance queries.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <vector>

#include "geometry/vec3.hpp"

namespace sanatrix {

struct Box {
  Vec3 low{std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
           std::numeric_limits<double>::max()};
  Vec3 high{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::lowest(),
            std::numeric_limits<double>::lowest()};

  void include(const Vec3& p) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  void include(const Box& other) {
    include(other.low);
    include(other.high);
  }
  [[nodiscard]] double squared_distance(const Vec3& p) const {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double outside = std::max({low[i] - p[i], p[i] - high[i], 0.0});
      sum += outside * outside;
    }
    return sum;
  }
};

class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box>& boxes) : items_(boxes.size()) {
    std::iota(items_.begin(), items_.end(), 0);
    nodes_.reserve(boxes.size());
    build(boxes, 0, static_cast<int>(boxes.size()));
  }

  /// Calls visit(item) for the items whose leaf lies within the squared distance `reach2` of p,
  /// near leaves first. visit may lower reach2 to say what is no longer of interest.
  template <class Visit>
  void within(const Vec3& p, double& reach2, Visit&& visit) const {
    struct Waiting {
      int node;
      double distance2;
    };
    std::array<Waiting, 64> stack;  // depth is at most log2(2^31) because halves are equal
    std::size_t depth = 0;
    stack[depth++] = {0, nodes_[0].box.squared_distance(p)};
    while (depth > 0) {
      const Waiting now = stack[--depth];
      if (now.distance2 > reach2) {
        continue;
      }
      const Node& node = nodes_[static_cast<std::size_t>(now.node)];
      if (node.right < 0) {
        for (int i = node.begin; i < node.end; ++i) {
          visit(items_[static_cast<std::size_t>(i)]);
        }
        continue;
      }
      Waiting near{now.node + 1, distance2(now.node + 1, p)};
      Waiting far{node.right, distance2(node.right, p)};
      if (far.distance2 < near.distance2) {
        std::swap(near, far);
      }
      stack[depth++] = far;
      stack[depth++] = near;
    }
  }

 private:
  struct Node {
    Box box;
    int begin, end;
    int right = -1;  ///< second child; the first follows its parent. -1: leaf
  };
  static constexpr int leaf_size = 4;

  [[nodiscard]] double distance2(int node, const Vec3& p) const {
    return nodes_[static_cast<std::size_t>(node)].box.squared_distance(p);
  }

  int build(const std::vector<Box>& boxes, int begin, int end) {
    const int index = static_cast<int>(nodes_.size());
    Node node{{}, begin, end};
    for (int i = begin; i < end; ++i) {
      node.box.include(boxes[static_cast<std::size_t>(items_[static_cast<std::size_t>(i)])]);
    }
    nodes_.push_back(node);
    if (end - begin > leaf_size) {
      const Vec3 extent = node.box.high - node.box.low;
      const auto axis =
          static_cast<std::size_t>(std::max_element(extent.begin(), extent.end()) - extent.begin());
      const int middle = begin + (end - begin) / 2;
      std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                       [&](int a, int b) {
                         const Box& x = boxes[static_cast<std::size_t>(a)];
                         const Box& y = boxes[static_cast<std::size_t>(b)];
                         return x.low[axis] + x.high[axis] < y.low[axis] + y.high[axis];
                       });
      build(boxes, begin, middle);
      const int right = build(boxes, middle, end);
      nodes_[static_cast<std::size_t>(index)].right = right;
    }
    return index;
  }

  std::vector<int> items_;
  std::vector<Node> nodes_;
};

}  // namespace sanatrix
