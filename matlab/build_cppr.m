function build_cppr(built)
%BUILD_CPPR  Builds what cppr.Robot calls, in MATLAB or Octave.
%
%   Run it once, in the folder matlab of the repository or with that folder on the path. It builds the C library with
%   cargo (Rust) and from it cppr_mex, which holds the library, with the C compiler that mex or mkoctfile is set up for.
%
%   build_cppr(FOLDER) takes the library from a folder where it has been built already. Beside a C library that was downloaded, build_cppr takes
%   that one, and needs no Rust.

folder = fileparts(mfilename('fullpath'));
root = fileparts(folder);
downloaded = fullfile(root, 'lib', 'libcppr.a');
if nargin < 1 && exist(downloaded, 'file')
    library = downloaded;
    include = ['-I' fullfile(root, 'include')];
else
    if nargin < 1
        built = build_library(root);
    end
    library = fullfile(built, 'libcppr_c.a');
    if ispc
        % Built by the MSVC toolchain of Rust.
        library = fullfile(built, 'cppr_c.lib');
    end
    include = ['-I' fullfile(root, 'crates', 'cppr-c', 'include')];
end
source = fullfile(folder, 'src', 'cppr_mex.c');
system_libraries = {'-lpthread', '-ldl', '-lm'};
if ispc
    % What Rust's standard library needs of Windows.
    system_libraries = {'-lws2_32', '-luserenv', '-lntdll', '-lbcrypt', '-ladvapi32'};
elseif ismac
    system_libraries = {'-lm'};
end
if exist('OCTAVE_VERSION', 'builtin')
    output = fullfile(folder, 'cppr_mex.mex');
    [text, failed] = mkoctfile('--mex', '-s', include, '-o', output, source, library, system_libraries{:});
    if failed
        error('cppr:build', 'cppr_mex could not be built:\n%s', text);
    end
else
    mex('-R2018a', include, '-outdir', folder, '-output', 'cppr_mex', source, library, system_libraries{:});
end
rehash % it is found without starting anew
disp(['cppr_mex is in ' folder '; put this folder on the path: addpath ' folder]);
end

function built = build_library(root)
manifest = fullfile(root, 'Cargo.toml');
[failed, text] = system(['cargo build --release --quiet -p cppr-c --manifest-path "' manifest '"']);
if failed
    error('cppr:build', ['the library could not be built (is Rust installed, and cargo on the PATH?):' 10 '%s'], text);
end
target = getenv('CARGO_TARGET_DIR');
if isempty(target)
    target = fullfile(root, 'target');
end
built = fullfile(target, 'release');
end
