"""By which data of files are known: their content, wherever they lie."""

import hashlib

from repro.data.data_options import RecordingFile
from repro.tracking.files import file_digest


def recording_digest(source: RecordingFile) -> str:
    """SHA-256 of the files of a recording in their order, in hexadecimal; of a single file, that of its bytes."""
    from repro.data.recording_file import files_read

    files, tests = files_read(source)
    if len(files) == 1 and not tests and not source.test_episodes:
        return file_digest(files[0])
    # The names of files are names of episodes, so they matter where test episodes are chosen.
    named = [path.name if source.test_episodes else "" for path in (*files, *tests)]
    lines = [f"{file_digest(path)} {name}" for path, name in zip((*files, *tests), named, strict=True)]
    return hashlib.sha256("\n".join([*lines, str(len(tests))]).encode()).hexdigest()
