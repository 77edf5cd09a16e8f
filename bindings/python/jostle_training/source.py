"""Which state of the source a network was trained with."""

import subprocess
from pathlib import Path


def commit_of_source():
    """The commit of the package and its configurations, with `-dirty` where files differ from it or are not in it; empty
    where the package is no part of a repository."""
    package = Path(__file__).resolve().parents[1]

    def git(*command):
        try:
            done = subprocess.run(["git", "-C", package, *command], capture_output=True, text=True, check=False)
        except OSError:
            return ""
        return done.stdout.strip() if done.returncode == 0 else ""

    # A copy of the package in somebody else's repository (a virtual environment, say) is not of that repository's commit.
    if not git("ls-files", "--", Path(__file__).resolve()):
        return ""
    return git("rev-parse", "HEAD") + ("-dirty" if git("status", "--porcelain", "--", ".") else "")
