// One main for all test programs; those whose layer needs PETSc start it once.
#include <gtest/gtest.h>

#ifdef SANATRIX_TEST_WITH_PETSC
#include "fem/session.hpp"
#endif

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
#ifdef SANATRIX_TEST_WITH_PETSC
  const sanatrix::fem::Session session;
#endif
  return RUN_ALL_TESTS();
}
