#!/usr/bin/env bash
# From nothing to the files in models/: makes data, trains, judges on held-out shapes, exports, lists. `make models` calls
# it with JOSTLE, PYTHON, DATA, MINUTES (of each training; 0.2 will do to see that all works), COUNT (of pushes; the others
# follow from it), SAMPLES (most that each is judged by; without it the network's own number) and INTO (the folder of models).
#
#   scripts/models.sh [dipn] [dipn_pure] [gc] [gn] [ppn] [segmentation]
#
# Data and checkpoints that are there are gone on from.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

jostle=${JOSTLE:-target/release/jostle}
python=${PYTHON:-python3}
data=${DATA:-out/training}
minutes=${MINUTES:-30}
count=${COUNT:-100000}
into=${INTO:-models}
mkdir -p "$data" "$into"
root=$PWD
data=$(cd "$data" && pwd)
into=$(cd "$into" && pwd)
case $jostle in /*) ;; *) jostle=$root/$jostle ;; esac

"$python" -c 'import torch, onnx, onnxruntime, safetensors, shapely' || {
    echo "models: $python lacks what training needs; see bindings/python/README.md" >&2
    exit 1
}

make_data() { # make_data KIND FOLDER COUNT SEED [OPTIONS]
    local kind=$1 folder=$2 samples=$3 seed=$4
    shift 4
    "$jostle" datagen "$kind" "$data/$folder" --count "$samples" --seed "$seed" "$@"
}
training() { # training CONFIG FOLDER CHECKPOINT MINUTES [OPTIONS]
    local config=$1 folder=$2 checkpoint=$3 time=$4
    shift 4
    "$python" -m jostle_training.train "configs/$config.toml" --data "$data/$folder" \
        --checkpoint "$data/$checkpoint.pt" --minutes "$time" --log "$data/$checkpoint.log" "$@"
}
finish() { # finish NAME FOLDER SAMPLES
    "$python" -m jostle_training.eval "$data/$1.pt" --data "$data/$2" --samples "${SAMPLES:-$3}" -o "$data/$1.json" >/dev/null
    "$python" -m jostle_training.export "$data/$1.pt" -o "$data/$1.onnx" --metrics "$data/$1.json"
    "$python" -m jostle_training.models "$into" "$1" "$data/$1.onnx" --metrics "$data/$1.json"
}

cd bindings/python
for name in "${@:-dipn}"; do
    case $name in
        dipn)
            make_data push push-prism "$count" 10 --physics prism
            training dipn push-prism dipn "$minutes"
            finish dipn push-prism 3000
            ;;
        dipn_pure)
            make_data push push-planar "$((count * 3))" 20 --physics planar
            make_data push push-prism "$count" 10 --physics prism
            training dipn_pure push-planar dipn_pure_planar "$minutes"
            training dipn_pure push-prism dipn_pure "$minutes" --from "$data/dipn_pure_planar.pt"
            finish dipn_pure push-prism 3000
            ;;
        gc | gn)
            make_data grasp grasp "$((count / 2))" 31
            training "$name" grasp "$name" "$minutes"
            test "$name" = gn || "$python" -m jostle_training.calibrate "$data/gc.pt" --data "$data/grasp"
            finish "$name" grasp 4000
            ;;
        ppn)
            make_data push push-planar "$((count * 3))" 20 --physics planar
            make_data ppn ppn "$((count / 20))" 40
            training ppn_motion push-planar ppn_motion "$(awk "BEGIN { print $minutes / 2 }")"
            training ppn ppn ppn "$minutes" --from "$data/ppn_motion.pt"
            finish ppn ppn 1000
            ;;
        segmentation)
            make_data segment segment "$((count / 12))" 40 --shard 4096
            training segmentation segment segmentation "$minutes"
            finish segmentation segment 400
            ;;
        *)
            echo "models: no network is called $name" >&2
            exit 2
            ;;
    esac
done
