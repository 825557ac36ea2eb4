// From where a picture is seen, and what its edges are called. Pictures must never confuse sides.
#pragma once

#include <string>

#include "geometry/vec3.hpp"
#include "render/render.hpp"

namespace sanatrix::render {

/// Unit vectors: from the scene to the viewer, and what is up in the picture.
struct Viewpoint {
  Vec3 towards_viewer, up;
};

Viewpoint viewpoint_of(View view);
/// Square to a cut, from the side from which doctors look: axial from the feet with anterior up,
/// coronal from the front, sagittal from the patient's left.
Viewpoint viewpoint_of_cut(const Vec3& normal);

/// What is on the right hand in the picture.
Vec3 to_the_right(const Viewpoint& view);
/// "L", or "LP" for a direction half-way between left and posterior.
std::string orientation_letters(const Vec3& direction);
/// "patient's LEFT" for a direction towards the patient's left, else "patient's RIGHT".
std::string side_in_words(const Vec3& direction);

}  // namespace sanatrix::render
