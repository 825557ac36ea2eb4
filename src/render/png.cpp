// Pixels of a window as a PNG file; registers VTK's graphics back ends.
#include "render/png.hpp"

#include <vtkAutoInit.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include "core/files.hpp"

VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)
VTK_MODULE_INIT(vtkRenderingContextOpenGL2)

namespace sanatrix::render {

void write_png(vtkRenderWindow& window, const std::filesystem::path& file) {
  vtkNew<vtkWindowToImageFilter> pixels;
  pixels->SetInput(&window);
  pixels->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(pixels->GetOutputPort());
  writer->SetCompressionLevel(1);  // a third of the time of VTK's 5 for a fifth more bytes
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray& bytes = *writer->GetResult();
  write_text(file, {reinterpret_cast<const char*>(bytes.GetPointer(0)),
                    static_cast<std::size_t>(bytes.GetNumberOfValues())});
}

}  // namespace sanatrix::render
