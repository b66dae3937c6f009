# cmake -D out=FILE.cpp -D page_dir=... -D theme=FILE.css -D script=FILE.js|"" -P embed.cmake
# The page's files as strings in C++.
file(READ ${page_dir}/index.html index)
file(READ ${theme} theme)
file(READ ${page_dir}/style.css style)
set(bundle "")
if(script)
  file(READ ${script} bundle)
endif()
string(SHA256 digest "${bundle}")
file(WRITE ${out} "#include \"view/page_sources.h\"\n\nnamespace atl::view::page {\n\n"
     "const char* const index = R\"~~~~(${index})~~~~\";\n\n"
     "const char* const style = R\"~~~~(${theme}${style})~~~~\";\n\n"
     "const char* const script = R\"~~~~(${bundle})~~~~\";\n\n"
     "const char* const script_sha256 = \"${digest}\";\n\n}  // namespace atl::view::page\n")
