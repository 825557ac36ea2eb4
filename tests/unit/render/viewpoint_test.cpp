// No picture may confuse the patient's sides.
#include "render/viewpoint.hpp"

#include <gtest/gtest.h>

namespace sanatrix::render {
namespace {

std::string edges(const Viewpoint& v) {
  const Vec3 right = to_the_right(v);
  return orientation_letters(-1.0 * right) + " " + orientation_letters(right) + " " +
         orientation_letters(v.up) + " " + orientation_letters(-1.0 * v.up);
}

TEST(Viewpoints, NameTheEdgesOfThePictureLeftRightTopBottom) {
  EXPECT_EQ(edges(viewpoint_of(View::Front)), "R L S I");
  EXPECT_EQ(edges(viewpoint_of(View::Left)), "A P S I");
  EXPECT_EQ(edges(viewpoint_of(View::Right)), "P A S I");
  EXPECT_EQ(edges(viewpoint_of(View::LeftOblique)), "RA LP S I");
  EXPECT_EQ(edges(viewpoint_of(View::RightOblique)), "RP LA S I");
  EXPECT_EQ(edges(viewpoint_of(View::Below)), "R L A P");
}

TEST(Viewpoints, CutsAreSeenFromTheUsualSideWhateverTheirNormalsSign) {
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_EQ(edges(viewpoint_of_cut({0, 0, sign})), "R L A P");
    EXPECT_EQ(edges(viewpoint_of_cut({0, sign, 0})), "R L S I");
    EXPECT_EQ(edges(viewpoint_of_cut({sign, 0, 0})), "A P S I");
  }
  const Viewpoint oblique = viewpoint_of_cut({0.4, -2.0, 0.7});
  EXPECT_NEAR(dot(oblique.up, oblique.towards_viewer), 0.0, 1e-15);
  EXPECT_NEAR(norm(oblique.up), 1.0, 1e-15);
  EXPECT_NEAR(norm(oblique.towards_viewer), 1.0, 1e-15);
  EXPECT_GT(to_the_right(oblique)[0], 0.9);
}

TEST(Viewpoints, WordsFollowThePatientAndNotThePicture) {
  EXPECT_EQ(side_in_words({1, 0, 0}), "patient's LEFT");
  EXPECT_EQ(side_in_words({-1, 0, 0}), "patient's RIGHT");
}

}  // namespace
}  // namespace sanatrix::render
