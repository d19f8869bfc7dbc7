"""The stages of the asset pipeline, one class per file and nothing else; `assetkit.pipeline` holds their order."""
