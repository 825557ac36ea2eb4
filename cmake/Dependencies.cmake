# Debian packages (apt-packages.txt), each behind one short target name.
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)
find_package(LibArchive REQUIRED)
find_package(MPI REQUIRED COMPONENTS CXX)
find_package(OpenMP REQUIRED COMPONENTS CXX)
find_package(TBB REQUIRED)
find_package(PkgConfig REQUIRED)

pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET petsc)
add_library(Petsc INTERFACE)
target_link_libraries(Petsc INTERFACE PkgConfig::PETSC MPI::MPI_CXX)

find_package(SUNDIALS REQUIRED)
add_library(Sundials INTERFACE)
target_link_libraries(Sundials INTERFACE SUNDIALS::cvode SUNDIALS::nvecpetsc SUNDIALS::sunlinsolspgmr)

find_package(Eigen3 REQUIRED)
find_package(CGAL REQUIRED)
add_library(Cgal INTERFACE)
target_link_libraries(Cgal INTERFACE CGAL::CGAL Eigen3::Eigen)

find_package(ITK REQUIRED COMPONENTS
  ITKCommon ITKIOImageBase ITKIONIFTI ITKIONRRD ITKIOMeta ITKZLIB ITKSmoothing ITKDistanceMap
  ITKImageGrid ITKLabelMap ITKMathematicalMorphology ITKConnectedComponents ITKThresholding)
add_library(Itk INTERFACE)
target_include_directories(Itk SYSTEM INTERFACE ${ITK_INCLUDE_DIRS})
target_link_libraries(Itk INTERFACE ${ITK_LIBRARIES})

find_package(VTK REQUIRED COMPONENTS
  CommonCore CommonDataModel IOXML IOGeometry IOPLY IOImage FiltersCore FiltersGeneral
  FiltersGeometry FiltersSources FiltersModeling RenderingCore RenderingOpenGL2
  RenderingAnnotation RenderingFreeType ChartsCore ViewsContext2D RenderingContextOpenGL2)
add_library(Vtk INTERFACE)
target_link_libraries(Vtk INTERFACE ${VTK_LIBRARIES})

# DCMTK's own list has all of its modules (network, signatures); reading needs these.
find_package(DCMTK REQUIRED CONFIG)
add_library(Dicom INTERFACE)
target_link_libraries(Dicom INTERFACE DCMTK::dcmdata DCMTK::dcmjpeg DCMTK::dcmjpls)
